# The Python package: built by itself with Debian's Python, and tested. Tests of captures and peers skip what is
# missing, which ctest counts by python_skipped.
add_test(NAME python
         COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/python/run.sh ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_BINARY_DIR}/python
                 $<TARGET_FILE:lcpbench> ${CMAKE_CXX_COMPILER})
set_tests_properties(python PROPERTIES LABELS "slow;release-only" SKIP_RETURN_CODE 77 COST 120
                                        TIMEOUT 900)  # without ccache it compiles for minutes
add_test(NAME python_skipped
         COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/python/skipped.sh ${CMAKE_CURRENT_BINARY_DIR}/python.tests.log)
set_tests_properties(python PROPERTIES FIXTURES_SETUP python_log)
set_tests_properties(python_skipped PROPERTIES LABELS "slow;release-only" SKIP_RETURN_CODE 77 FIXTURES_REQUIRED python_log)
