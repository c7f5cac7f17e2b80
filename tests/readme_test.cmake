# The README's programs are examples, word for word.
#   cmake -DSOURCE_DIR=... -P readme_test.cmake
file(READ ${SOURCE_DIR}/README.md readme)

# expect(LANGUAGE EXAMPLE START): from START on, the example is in the README.
function(expect language example start)
  file(READ ${SOURCE_DIR}/${example} text)
  string(FIND "${text}" "${start}" at)
  string(SUBSTRING "${text}" ${at} -1 program)
  string(FIND "${readme}" "```${language}\n${program}```" found)
  if(found EQUAL -1)
    message(FATAL_ERROR "README.md does not show ${example} as it is")
  endif()
endfunction()

expect(cpp examples/01_track_raw_frames.cpp "#include")
expect(c examples/06_track_in_c.c "#include")
expect(python bindings/python/examples/webcam.py "import")
