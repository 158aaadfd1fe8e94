lcpbench_test(store LINK lcpbench_study)
lcpbench_test(store_faults LINK lcpbench_study)
lcpbench_test(store_sharing LINK lcpbench_study)
lcpbench_test(merge LINK lcpbench_study)
lcpbench_test(plan LINK lcpbench_study lcpbench_solver_list)
lcpbench_test(runner LINK lcpbench_runner lcpbench_study lcpbench_solver_list lcpbench_adapters)
lcpbench_test(runner_faults LINK lcpbench_runner lcpbench_study lcpbench_solver_list lcpbench_adapters)
target_compile_definitions(runner_faults_test PRIVATE FAULT_WORKER="$<TARGET_FILE:fault_worker>")
add_dependencies(runner_faults_test fault_worker)

lcpbench_test(start_last LINK lcpbench_runner lcpbench_study lcpbench_solver_list lcpbench_adapters)
lcpbench_test(work_queue LINK lcpbench_runner lcpbench_study lcpbench_solver_list)

find_package(Python3 REQUIRED COMPONENTS Interpreter)
# The short share. The long form is one command: tests/study/store_attack.py PROGRAM.
add_test(NAME store_attack
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/study/store_attack.py $<TARGET_FILE:lcpbench>
                 --kills 16 --flips 51 --faults 51)
set_tests_properties(store_attack PROPERTIES LABELS slow)

# The commands of docs/howto/cluster.md, by GNU parallel and by a Slurm of the test's own.
foreach(driver parallel slurm)
  add_test(NAME cluster_${driver}
           COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/study/cluster_test.py ${driver} $<TARGET_FILE:lcpbench>)
  set_tests_properties(cluster_${driver} PROPERTIES SKIP_RETURN_CODE 77)
endforeach()
set_tests_properties(cluster_slurm PROPERTIES LABELS "slow;release-only" RUN_SERIAL TRUE)

# A tool for measurements: stores of many answers, for `merge` and `report`.
add_executable(large_store ${CMAKE_CURRENT_SOURCE_DIR}/study/large_store.cpp)
target_link_libraries(large_store PRIVATE lcpbench_study)

# These run the program itself.
lcpbench_test(cli LINK lcpbench_study nlohmann_json::nlohmann_json)
lcpbench_test(documents LINK lcpbench_study nlohmann_json::nlohmann_json)
lcpbench_test(first_use LINK lcpbench_study)
lcpbench_test(surroundings LINK lcpbench_study)
lcpbench_test(terminal LINK lcpbench_report lcpbench_study)
lcpbench_test(kill SLOW LINK lcpbench_study)
foreach(name cli documents first_use surroundings terminal kill)
  target_compile_definitions(${name}_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
  add_dependencies(${name}_test lcpbench lcpbench_workers)
endforeach()

lcpbench_test(shrink LINK lcpbench_shrink lcpbench_solver_list nlohmann_json::nlohmann_json)
target_compile_definitions(shrink_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(shrink_test lcpbench lcpbench_workers)

lcpbench_test(replay_measures LINK lcpbench_report nlohmann_json::nlohmann_json)
lcpbench_test(replay LINK lcpbench_report nlohmann_json::nlohmann_json)
target_compile_definitions(replay_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(replay_test lcpbench lcpbench_engines)

lcpbench_test(view LINK lcpbench_view lcpbench_generators nlohmann_json::nlohmann_json)
target_compile_definitions(view_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(view_test lcpbench)
add_test(NAME view_schema
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/study/view_schema_test.py $<TARGET_FILE:lcpbench>
                 ${PROJECT_SOURCE_DIR})

# Counts of a fixed study. Not under sanitizers: it is long there and would say the same.
lcpbench_test(regression LINK lcpbench_study nlohmann_json::nlohmann_json)
target_compile_definitions(regression_test PRIVATE
  LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>"
  LCPBENCH_PLAN="${CMAKE_CURRENT_SOURCE_DIR}/study/regression_plan.json"
  LCPBENCH_COUNTS="${CMAKE_CURRENT_SOURCE_DIR}/golden/regression.json")
add_dependencies(regression_test lcpbench)
set_tests_properties(regression PROPERTIES LABELS release-only)

# Our solvers against the reference libraries.
lcpbench_test(velocity_agreement LINK lcpbench_report lcpbench_study lcpbench_solver_list)
lcpbench_test(validate LINK lcpbench_runner lcpbench_report lcpbench_study lcpbench_solver_list nlohmann_json::nlohmann_json)
target_compile_definitions(validate_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(validate_test lcpbench lcpbench_workers)

# Every solver on problems with a planted answer; every adapter beside workers that misbehave.
lcpbench_test(definite LINK lcpbench_runner lcpbench_study lcpbench_solver_list)
add_dependencies(definite_test lcpbench_workers)
lcpbench_test(adapter_faults SLOW LINK lcpbench_runner lcpbench_study lcpbench_solver_list lcpbench_adapters)
target_compile_definitions(adapter_faults_test PRIVATE FAULT_WORKER="$<TARGET_FILE:fault_worker>")
add_dependencies(adapter_faults_test fault_worker lcpbench_workers)
lcpbench_test(models LINK lcpbench_models lcpbench_generators lcpbench_evaluation)
