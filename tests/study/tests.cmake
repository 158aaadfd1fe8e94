lcpbench_room(store LINK lcpbench_study lcpbench_solver_list)
foreach(test store store_faults merge plan)
  lcpbench_test(${test})
endforeach()

lcpbench_room(study
  LINK lcpbench_runner lcpbench_report lcpbench_shrink lcpbench_view lcpbench_models lcpbench_study lcpbench_generators
    lcpbench_evaluation lcpbench_adapters lcpbench_solver_list nlohmann_json::nlohmann_json
  NEEDS lcpbench lcpbench_workers lcpbench_engines fault_worker
  DEFINE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>" FAULT_WORKER="$<TARGET_FILE:fault_worker>"
    LCPBENCH_PLAN="${CMAKE_CURRENT_SOURCE_DIR}/study/regression_plan.json"
    LCPBENCH_COUNTS="${CMAKE_CURRENT_SOURCE_DIR}/golden/regression.json")
foreach(test runner start_last work_queue cli documents surroundings terminal shrink replay_measures replay view
        velocity_agreement validate definite models shown_rows)
  lcpbench_test(${test})
endforeach()
lcpbench_test(kill SLOW)
lcpbench_test(regression RELEASE_ONLY)  # counts of a fixed study: sanitizers would say the same

find_package(Python3 REQUIRED COMPONENTS Interpreter)
# The commands of docs/howto/cluster.md, by GNU parallel and by a Slurm of the test's own.
foreach(driver parallel slurm)
  add_test(NAME cluster_${driver}
           COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/study/cluster_test.py ${driver} $<TARGET_FILE:lcpbench>)
  set_tests_properties(cluster_${driver} PROPERTIES SKIP_RETURN_CODE 77)
endforeach()
set_tests_properties(cluster_slurm PROPERTIES LABELS "slow;release-only" TIMEOUT 900)  # it waits for Slurm

add_test(NAME view_schema
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/study/view_schema_test.py $<TARGET_FILE:lcpbench>
                 ${PROJECT_SOURCE_DIR})
