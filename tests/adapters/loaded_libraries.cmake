# cmake -DBINARY=file -DLIBRARIES=regex -DEXPECT=NONE|SOME -P loaded_libraries.cmake
# Fails when the shared libraries of BINARY match LIBRARIES against EXPECT. SOME shows that the check can see them.
execute_process(COMMAND ldd ${BINARY} OUTPUT_VARIABLE loaded RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "ldd ${BINARY} failed")
endif()
string(REGEX MATCHALL "${LIBRARIES}[^ \n]*" found "${loaded}")
if(EXPECT STREQUAL "NONE" AND found)
  message(FATAL_ERROR "${BINARY} loads ${found}")
endif()
if(EXPECT STREQUAL "SOME" AND NOT found)
  message(FATAL_ERROR "${BINARY} loads none of ${LIBRARIES}")
endif()
