# The conformance suite meets whatever is registered.
lcpbench_test(conformance LINK lcpbench_solver_list)
target_sources(conformance_test PRIVATE support/allocation_counter.cpp)

lcpbench_test(active_set LINK lcpbench_native lcpbench_generators lcpbench_evaluation lcpbench_statistics)
target_sources(active_set_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(active_set_bounds LINK lcpbench_native)
lcpbench_test(auto LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
lcpbench_test(auto_steps LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
target_sources(auto_steps_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(sparse_pivoting LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
lcpbench_test(race LINK lcpbench_solver_list lcpbench_generators)
lcpbench_test(auto_scenes LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
lcpbench_test(warm_steps LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
target_sources(warm_steps_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(claims LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
target_sources(claims_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(bare_claims LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
lcpbench_test(contact_claims LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
lcpbench_test(inertia_claims LINK lcpbench_attack)
lcpbench_test(contact_farkas LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
lcpbench_test(resumed_pivoting LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
target_sources(resumed_pivoting_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(contact_lemke LINK lcpbench_native lcpbench_generators lcpbench_evaluation lcpbench_statistics)
target_sources(contact_lemke_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(contact_lemke_paths LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
target_sources(contact_lemke_paths_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(soft_contacts LINK lcpbench_solver_list lcpbench_generators lcpbench_evaluation)
lcpbench_test(exact_search LINK lcpbench_native)
lcpbench_test(island_units LINK lcpbench_native)
lcpbench_test(primal_dual LINK lcpbench_native)
lcpbench_test(multifrontal_cholesky LINK lcpbench_native)
target_sources(multifrontal_cholesky_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(velocity_ipm LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
target_sources(velocity_ipm_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(friction_ipm LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
target_sources(friction_ipm_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(scene_memory SLOW LINK lcpbench_solver_list lcpbench_evaluation lcpbench_io)
set_property(TEST scene_memory APPEND PROPERTY LABELS release-only)  # sanitizers have memory of their own
lcpbench_test(cone_ipm LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
target_sources(cone_ipm_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(regularized LINK lcpbench_native lcpbench_generators)
target_sources(regularized_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(principal_pivoting LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
lcpbench_test(psor LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
target_sources(psor_test PRIVATE support/allocation_counter.cpp)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME auto_fit COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/native/auto_fit_test.py)
lcpbench_test(resumable LINK lcpbench_native lcpbench_generators lcpbench_evaluation)
target_sources(resumable_test PRIVATE support/allocation_counter.cpp)
lcpbench_test(ordered_lu LINK lcpbench_native)

# Once at the level in use, and once at each level; those that this processor lacks are skipped.
lcpbench_test(lemke LINK lcpbench_native lcpbench_generators)
lcpbench_test(lemke_sweep LINK lcpbench_native lcpbench_generators)
target_sources(lemke_sweep_test PRIVATE support/allocation_counter.cpp)
get_property(levels GLOBAL PROPERTY LCPBENCH_LEMKE_LEVELS)
set_tests_properties(lemke contact_lemke contact_lemke_paths PROPERTIES LABELS release-only)  # sanitizers see each level below
foreach(level IN LISTS levels)
  add_test(NAME lemke_${level} COMMAND lemke_test)
  add_test(NAME contact_lemke_${level} COMMAND contact_lemke_test)
  add_test(NAME contact_lemke_paths_${level} COMMAND contact_lemke_paths_test)
  set_tests_properties(lemke_${level} contact_lemke_${level} contact_lemke_paths_${level} PROPERTIES ENVIRONMENT "LCPBENCH_ISA=${level}"
                                                 SKIP_REGULAR_EXPRESSION "this processor has no more than")
  foreach(method lemke active_set cholesky contact_lemke)
    if(TARGET lcpbench_${method}_${level} AND NOT LCPBENCH_SANITIZE)  # sanitizers add symbols of their own
      add_test(NAME ${method}_symbols_${level}
               COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DLEVEL=${level}
                       -DOBJECT=$<TARGET_OBJECTS:lcpbench_${method}_${level}>
                       -P ${CMAKE_CURRENT_SOURCE_DIR}/native/lemke_symbols.cmake)
    endif()
  endforeach()
endforeach()

# Lemke in other precisions than double, and what its engines allocate.
lcpbench_test(lemke_precision
  LINK lcpbench_native lcpbench_generators lcpbench_certify lcpbench_evaluation lcpbench_solver_list lcpbench_statistics)
target_sources(lemke_precision_test PRIVATE support/allocation_counter.cpp)
if(NOT LCPBENCH_SANITIZE)
  add_test(NAME lemke_ordered_symbols
           COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DLEVEL=ordered
                   -DOBJECT=$<TARGET_OBJECTS:lcpbench_lemke_ordered_ordered>
                   -P ${CMAKE_CURRENT_SOURCE_DIR}/native/lemke_symbols.cmake)
endif()
lcpbench_test(steppers LINK lcpbench_steppers lcpbench_solver_list)
