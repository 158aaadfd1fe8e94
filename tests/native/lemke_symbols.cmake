# cmake -DNM=nm -DLEVEL=avx2 -DOBJECT=file.o -P lemke_symbols.cmake
#
# Fails when an object compiled for one instruction-set level defines a symbol that another part of the program could
# pick up: anything global or weak outside the namespaces that carry the level's name.
execute_process(COMMAND ${NM} --demangle --defined-only --extern-only ${OBJECT} OUTPUT_VARIABLE symbols
                RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "${NM} cannot read ${OBJECT}")
endif()
string(REPLACE ";" "," symbols "${symbols}")
string(REGEX REPLACE "\n+" ";" symbols "${symbols}")

set(count 0)
set(leaks "")
foreach(symbol IN LISTS symbols)
  if(symbol STREQUAL "")
    continue()
  endif()
  math(EXPR count "${count} + 1")
  # DW.ref.*: the compiler's pointer to the exception personality, the same in every object.
  if(NOT symbol MATCHES "lcpbench::[a-z_]+::${LEVEL}::|Eigen_${LEVEL}::| DW\\.ref\\.")
    string(APPEND leaks "\n  ${symbol}")
  endif()
endforeach()
if(count EQUAL 0)
  message(FATAL_ERROR "${OBJECT} defines no symbol: not the engines")
endif()
if(leaks)
  message(FATAL_ERROR "compiled for ${LEVEL} only, yet visible to the rest of the program:${leaks}")
endif()
message(STATUS "${count} symbols, all under the level's own names")
