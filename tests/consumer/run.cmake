# Installs handyar, builds the consumer against what was installed, runs it.
#   cmake -DBUILD_DIR=... -DWORK_DIR=... -DGENERATOR=... -DC=... -DCXX=... -DCXX_FLAGS=...
#     -DROOMS="io;calibration;world" -P run.cmake
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

set(prefix ${WORK_DIR}/prefix)
set(examples ${CMAKE_CURRENT_LIST_DIR}/../../examples)
file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})

string(REPLACE ";" "\\;" rooms "${ROOMS}")  # one argument
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/build -G ${GENERATOR}
  -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_BUILD_TYPE=Debug "-DROOMS=${rooms}"
  -DEXAMPLES_DIR=${examples} -DCMAKE_C_COMPILER=${C} -DCMAKE_C_FLAGS=${CXX_FLAGS}
  -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${CXX_FLAGS})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/consumer)

# by_pkg_config(COMPILER SOURCE PACKAGE...): the source, built with what pkg-config tells.
function(by_pkg_config compiler source)
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ${ARGN}
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${CXX_FLAGS} ${flags}")
  run(${compiler} ${source} ${flags} -o ${WORK_DIR}/by_pkg_config)
endfunction()

find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  file(GLOB_RECURSE pc ${prefix}/handyar.pc)
  get_filename_component(pc_dir ${pc} DIRECTORY)
  set(ENV{PKG_CONFIG_PATH} ${pc_dir})
  set(ENV{LD_LIBRARY_PATH} ${pc_dir}/..)
  foreach(room IN LISTS ROOMS)
    set(example 03_track_video)
    if(room STREQUAL "world")
      set(example 07_world)
    endif()
    by_pkg_config("${CXX};-std=c++20" ${examples}/${example}.cpp handyar-${room} handyar-io)
  endforeach()
  by_pkg_config("${C};-std=c99" ${examples}/06_track_in_c.c handyar)
  by_pkg_config("${CXX};-std=c++20" ${CMAKE_CURRENT_LIST_DIR}/main.cpp handyar)
  run(${WORK_DIR}/by_pkg_config)
endif()

# complains(ABOUT): the installed program, told to inspect what is not there among markers, names
# what it misses first.
function(complains about)
  execute_process(COMMAND ${prefix}/bin/handyar inspect none.mp4
    --scene ${CMAKE_CURRENT_LIST_DIR}/../../data/scene_select.json
    ERROR_VARIABLE said RESULT_VARIABLE code)
  if(NOT code EQUAL 1 OR NOT said MATCHES "${about}")
    message(FATAL_ERROR "handyar inspect should complain about ${about}, and says: ${said}")
  endif()
endfunction()

if(EXISTS ${prefix}/bin/handyar)
  run(${prefix}/bin/handyar --version)
  file(GLOB_RECURSE module ${prefix}/*handyar-markers*)
  if(module)
    complains("none.mp4: no such file")
    file(REMOVE ${module})
  endif()
  complains("markers: .*install the package handyar-markers")
  file(GLOB_RECURSE pages ${prefix}/*/handyar*.1.gz)
  list(LENGTH pages count)
  execute_process(COMMAND bash -c
    "source $0; COMP_WORDS=($1 track --met); COMP_CWORD=2; _handyar; echo $COMPREPLY"
    ${prefix}/share/bash-completion/completions/handyar ${prefix}/bin/handyar
    OUTPUT_VARIABLE completed OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  if(count LESS 5 OR NOT completed STREQUAL "--method")
    message(FATAL_ERROR "${count} manual pages; --met is completed to '${completed}'")
  endif()
endif()
