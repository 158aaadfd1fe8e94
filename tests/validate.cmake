# Our solvers against the reference libraries.
lcpbench_test(velocity_agreement LINK lcpbench_study lcpbench_solver_list)
lcpbench_test(validate LINK lcpbench_runner lcpbench_study lcpbench_solver_list nlohmann_json::nlohmann_json)
target_compile_definitions(validate_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(validate_test lcpbench lcpbench_workers)

# Every solver on problems with a planted answer; every adapter beside workers that misbehave.
lcpbench_test(definite LINK lcpbench_runner lcpbench_study lcpbench_solver_list)
add_dependencies(definite_test lcpbench_workers)
lcpbench_test(adapter_faults SLOW LINK lcpbench_runner lcpbench_study lcpbench_solver_list lcpbench_adapters)
target_compile_definitions(adapter_faults_test PRIVATE FAULT_WORKER="$<TARGET_FILE:fault_worker>")
add_dependencies(adapter_faults_test fault_worker lcpbench_workers)
