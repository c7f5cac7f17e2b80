# The shared library shows the symbols in exported_symbols.txt and no others: a new one is added
# there on purpose, a removed one needs another major version.
#   cmake -DNM=... -DLIBRARY=... -P exported_symbols.cmake
execute_process(COMMAND ${NM} --dynamic --defined-only --demangle --without-symbol-versions ${LIBRARY}
  OUTPUT_VARIABLE lines COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" lines "${lines}")
list(FILTER lines EXCLUDE REGEX " A HANDYAR_1$")
list(TRANSFORM lines REPLACE "^[0-9a-f]+ [A-Za-z] " "")
list(SORT lines)
list(REMOVE_DUPLICATES lines)  # a constructor has several symbols

file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/exported_symbols.txt expected)
set(added ${lines})
list(REMOVE_ITEM added ${expected})
set(missing ${expected})
list(REMOVE_ITEM missing ${lines})
foreach(symbol IN LISTS added)
  message(SEND_ERROR "exported, but not in tests/exported_symbols.txt: ${symbol}")
endforeach()
foreach(symbol IN LISTS missing)
  message(SEND_ERROR "in tests/exported_symbols.txt, but not exported: ${symbol}")
endforeach()
