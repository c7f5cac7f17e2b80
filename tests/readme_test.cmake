# The README's program is the first example, word for word.
#   cmake -DSOURCE_DIR=... -P readme_test.cmake
file(READ ${SOURCE_DIR}/README.md readme)
file(READ ${SOURCE_DIR}/examples/01_track_raw_frames.cpp example)
string(FIND "${example}" "#include" start)
string(SUBSTRING "${example}" ${start} -1 program)
string(FIND "${readme}" "```cpp\n${program}```" found)
if(found EQUAL -1)
  message(FATAL_ERROR "README.md does not show examples/01_track_raw_frames.cpp as it is")
endif()
