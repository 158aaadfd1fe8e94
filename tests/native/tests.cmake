lcpbench_room(native LINK lcpbench_solver_list lcpbench_native lcpbench_steppers lcpbench_generators lcpbench_evaluation
              lcpbench_statistics)
foreach(test conformance active_set auto auto_rest auto_scenes bare_claims bounded_rows budgeted claims cone_ipm contact_farkas contact_ipm
        even_impulses friction_ipm island_units mixed_lcp multifrontal primal_dual principal_pivoting
        proximal_newton psor soft_contacts steppers support_search
        velocity_ipm warm_steps)
  lcpbench_test(${test})
endforeach()
# An engine's templates, each at a level of its own.
foreach(test active_set_bounds response rounded_shares)
  lcpbench_test(${test})
  set_source_files_properties(${CMAKE_CURRENT_LIST_DIR}/${test}_test.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endforeach()
lcpbench_test(scene_memory SLOW RELEASE_ONLY APART OPTIMIZED  # sanitizers have memory of their own
              LINK lcpbench_solver_list lcpbench_evaluation lcpbench_io)
lcpbench_test(regularized APART LINK lcpbench_native lcpbench_generators)

# At the level in use, the highest of this processor, and at each level below the highest that has an engine; those that
# this processor lacks are skipped. Engines beyond double have no levels.
foreach(test lemke contact_lemke contact_lemke_paths)
  lcpbench_test(${test})
endforeach()
foreach(entry lemke_baseline lemke_avx2 contact_lemke_baseline contact_lemke_paths_baseline)
  string(REGEX MATCH "^(.*)_([a-z0-9]+)$" entry ${entry})
  add_test(NAME ${entry} COMMAND native_tests ${CMAKE_MATCH_1}
           --gtest_filter=-ContactLemkeTest.SolvesLargeIllConditionedProblems)
  set_tests_properties(${entry} PROPERTIES LABELS native ENVIRONMENT "LCPBENCH_ISA=${CMAKE_MATCH_2}"
                                           SKIP_REGULAR_EXPRESSION "this processor has no more than")
endforeach()
get_property(levels GLOBAL PROPERTY LCPBENCH_LEMKE_LEVELS)
foreach(level IN LISTS levels)
  foreach(method lemke active_set cholesky contact_lemke)
    if(TARGET lcpbench_${method}_${level} AND NOT LCPBENCH_SANITIZE)  # sanitizers add symbols of their own
      add_test(NAME ${method}_symbols_${level}
               COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DLEVEL=${level}
                       -DOBJECT=$<TARGET_OBJECTS:lcpbench_${method}_${level}>
                       -P ${CMAKE_CURRENT_SOURCE_DIR}/native/lemke_symbols.cmake)
    endif()
  endforeach()
endforeach()
