add_test(NAME layers COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/layers.cmake)
add_test(NAME one_definition
         COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/one_definition.cmake)
lcpbench_test(spec LINK lcpbench_core)
lcpbench_test(settings LINK lcpbench_core)
lcpbench_test(contact_problem LINK lcpbench_core)
lcpbench_test(solver LINK lcpbench_core)
lcpbench_test(isa LINK lcpbench_core)
lcpbench_test(utf8 LINK lcpbench_core)
