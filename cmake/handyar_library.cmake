# handyar_library(NAME source...): the library handyar_NAME with the alias handyar::NAME; NAME may be
# followed by a kind of library. All can go into a shared one and show nothing that is not marked
# with HANDYAR_API.
function(handyar_library name)
  add_library(handyar_${name} ${ARGN})
  add_library(handyar::${name} ALIAS handyar_${name})
  set_target_properties(handyar_${name} PROPERTIES
    EXPORT_NAME ${name}
    POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON)
  get_target_property(kind handyar_${name} TYPE)
  if(NOT kind STREQUAL "INTERFACE_LIBRARY")
    handyar_warnings(handyar_${name})
  endif()
endfunction()

# handyar_room(NAME source...): the same for a room beside the core, a static library with headers in
# include/ and sources in src/.
function(handyar_room name)
  handyar_library(${name} STATIC ${ARGN})
  target_include_directories(handyar_${name}
    PUBLIC
      $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
      $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE src)
endfunction()

# The project's own code builds without a warning; those who use it are not held to that.
function(handyar_warnings target)
  target_compile_options(${target} PRIVATE
    $<$<CXX_COMPILER_ID:GNU,Clang>:-Wall;-Wextra;-Wpedantic;-Wshadow;-Wno-psabi>
    $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-restrict>  # GCC 12 warns of its own std::string (PR 105651)
    $<$<BOOL:${HANDYAR_WERROR}>:-Werror>)
endfunction()
