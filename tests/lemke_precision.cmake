# Lemke in other precisions than double.
lcpbench_test(lemke_precision LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
target_sources(lemke_precision_test PRIVATE allocation_counter.cpp)
if(NOT LCPBENCH_SANITIZE)
  get_property(levels GLOBAL PROPERTY LCPBENCH_LEMKE_LEVELS)
  foreach(level IN LISTS levels)
    add_test(NAME lemke_precision_symbols_${level}
             COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DLEVEL=${level}
                     -DOBJECT=$<TARGET_OBJECTS:lcpbench_lemke_precision_${level}>
                     -P ${CMAKE_CURRENT_SOURCE_DIR}/lemke_symbols.cmake)
  endforeach()
endif()

# Measurements, not tests.
add_executable(precision_ladder EXCLUDE_FROM_ALL ${CMAKE_CURRENT_SOURCE_DIR}/precision_ladder.cpp)
target_link_libraries(precision_ladder PRIVATE lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
add_executable(isa_levels EXCLUDE_FROM_ALL ${CMAKE_CURRENT_SOURCE_DIR}/isa_levels.cpp)
target_link_libraries(isa_levels PRIVATE lcpbench_native lcpbench_generators lcpbench_evaluation lcpbench_statistics)
