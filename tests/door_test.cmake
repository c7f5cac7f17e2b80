# tracker.hpp is a small door: at most eight headers of the project, itself among them, come in.
#   cmake -DCXX=... -DSOURCE_DIR=... -DEIGEN=... -P door_test.cmake
set(headers ${SOURCE_DIR}/include)
execute_process(
  COMMAND ${CXX} -std=c++20 -MM -I${headers} -isystem ${EIGEN} ${headers}/handyar/tracker.hpp
  OUTPUT_VARIABLE rule COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "handyar/[a-z_/]+\\.(h|hpp)" found "${rule}")
list(REMOVE_DUPLICATES found)
list(LENGTH found count)
if(count LESS 2 OR count GREATER 8)
  message(FATAL_ERROR "tracker.hpp brings in ${count} headers: ${found}")
endif()
