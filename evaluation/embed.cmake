# cmake -DOUT=page.cpp -DHEADER=page.hpp -DNAMES=kA;kB -DFILES=a.js;b.css -P embed.cmake
# Text files as string views of a C++ source, so that a report needs no file beside the program.
set(header "// Made by embed.cmake.\n#pragma once\n#include <string_view>\n\nnamespace handyar::evaluation::page {\n")
set(source "// Made by embed.cmake.\n#include \"page.hpp\"\n\nnamespace handyar::evaluation::page {\n")
foreach(name file IN ZIP_LISTS NAMES FILES)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "char(0x\\1)," bytes "${bytes}")
  string(APPEND header "extern const std::string_view ${name};\n")
  string(APPEND source "static constexpr char ${name}Bytes[] = {${bytes}};\n"
    "const std::string_view ${name}{${name}Bytes, sizeof ${name}Bytes};\n")
endforeach()
file(WRITE ${HEADER} "${header}}  // namespace handyar::evaluation::page\n")
file(WRITE ${OUT} "${source}}  // namespace handyar::evaluation::page\n")
