add_executable(fault_worker adapters/fault_worker.cpp)
target_link_libraries(fault_worker PRIVATE lcpbench_worker_runtime)
add_executable(worker_parent adapters/worker_parent.cpp)
target_link_libraries(worker_parent PRIVATE lcpbench_adapters)

lcpbench_test(worker_protocol LINK lcpbench_adapters)
lcpbench_test(worker LINK lcpbench_adapters)
target_compile_definitions(worker_test PRIVATE FAULT_WORKER="$<TARGET_FILE:fault_worker>"
                                               WORKER_PARENT="$<TARGET_FILE:worker_parent>")
target_sources(worker_test PRIVATE adapters/worker_empty_poll.cpp)
add_dependencies(worker_test fault_worker worker_parent)

# Foreign libraries are loaded by the workers and by nothing else.
function(lcpbench_links_test name target expectation)
  add_test(NAME ${name}
           COMMAND ${CMAKE_COMMAND} -DBINARY=$<TARGET_FILE:${target}> -DEXPECT=${expectation}
                   "-DLIBRARIES=lib(ode|Bullet|LinearMath|ipopt|siconos|dart|SimTK|path|cholmod|umfpack|mumps|openblas|blas|lapack|gfortran)"
                   -P ${CMAKE_CURRENT_SOURCE_DIR}/adapters/loaded_libraries.cmake)
endfunction()

lcpbench_links_test(adapters_link_no_foreign_library worker_test NONE)
lcpbench_links_test(program_links_no_foreign_library lcpbench NONE)
if(TARGET lcpbench-worker-bullet)
  lcpbench_links_test(worker_links_its_library lcpbench-worker-bullet SOME)
endif()

lcpbench_test(adapter_conventions LINK lcpbench_study)
add_dependencies(adapter_conventions_test lcpbench_workers)
if(BULLET_FOUND)
  lcpbench_test(bullet_direct LINK lcpbench_study PkgConfig::BULLET)
  add_dependencies(bullet_direct_test lcpbench_workers)
endif()
lcpbench_test(adapter_friction LINK lcpbench_study)
add_dependencies(adapter_friction_test lcpbench_workers)
lcpbench_test(adapter_hostile LINK lcpbench_study)
add_dependencies(adapter_hostile_test lcpbench_workers)
lcpbench_test(adapter_cone LINK lcpbench_study)
add_dependencies(adapter_cone_test lcpbench_workers)
lcpbench_test(quickstep_sor LINK lcpbench_study)  # against the real QuickStep
target_sources(quickstep_sor_test PRIVATE support/allocation_counter.cpp)
add_dependencies(quickstep_sor_test lcpbench_workers)

lcpbench_test(large_scenes SLOW OPTIMIZED LINK lcpbench_study)
add_dependencies(large_scenes_test lcpbench_workers)
lcpbench_test(velocity_ipm_cholmod LINK lcpbench_study)
add_dependencies(velocity_ipm_cholmod_test lcpbench_workers)

# PATH, played by stand-ins with the two layouts of its structures.
foreach(version 4 5)
  add_library(path_stand_in_${version} MODULE adapters/path_stand_in.cpp)
  target_compile_definitions(path_stand_in_${version} PRIVATE STAND_IN_VERSION=${version})
endforeach()
lcpbench_test(adapter_path LINK lcpbench_adapters lcpbench_adapter_descriptions lcpbench_solver_list)
target_compile_definitions(adapter_path_test PRIVATE PATH_WORKER="$<TARGET_FILE:lcpbench-worker-path>"
  STAND_IN_4="$<TARGET_FILE:path_stand_in_4>" STAND_IN_5="$<TARGET_FILE:path_stand_in_5>")
add_dependencies(adapter_path_test lcpbench-worker-path path_stand_in_4 path_stand_in_5)

# Programs of a user's own: the example's, and one that misbehaves.
lcpbench_test(external LINK lcpbench_study lcpbench_adapters lcpbench_generators lcpbench_solver_list
                            lcpbench_external_json)
target_sources(external_test PRIVATE adapters/external_safety_test.cpp adapters/worker_empty_poll.cpp
                                     ${PROJECT_SOURCE_DIR}/adapters/worker/child_processes.cpp)
target_compile_definitions(external_test PRIVATE EXTERNAL_WORKER="$<TARGET_FILE:lcpbench-worker-external>"
  EXTERNAL_FAULTS="${CMAKE_CURRENT_SOURCE_DIR}/adapters/external_faults.py"
  LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>" REPOSITORY="${PROJECT_SOURCE_DIR}")
add_dependencies(external_test lcpbench lcpbench-worker-external)

# Engines that capture scenes.
lcpbench_test(close_parts LINK lcpbench_capture lcpbench_steppers lcpbench_solver_list)
foreach(test capture_command capture_files external_engine)
  lcpbench_test(${test} LINK lcpbench_io nlohmann_json::nlohmann_json)
  target_compile_definitions(${test}_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>"
                             REPOSITORY="${PROJECT_SOURCE_DIR}")
  add_dependencies(${test}_test lcpbench lcpbench_engines)
endforeach()
lcpbench_test(engine_solver LINK lcpbench_study)
