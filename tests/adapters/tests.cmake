add_executable(fault_worker adapters/fault_worker.cpp)
target_link_libraries(fault_worker PRIVATE lcpbench_worker_runtime)

lcpbench_room(protocol)
lcpbench_test(worker_protocol APART LINK lcpbench_adapters)
lcpbench_test(worker APART LINK lcpbench_adapters NEEDS fault_worker
  DEFINE FAULT_WORKER="$<TARGET_FILE:fault_worker>")

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

lcpbench_room(adapters
  LINK lcpbench_study lcpbench_io lcpbench_capture lcpbench_steppers lcpbench_solver_list nlohmann_json::nlohmann_json
  NEEDS lcpbench lcpbench_workers lcpbench_engines lcpbench-worker-path path_stand_in_4 path_stand_in_5
  DEFINE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>" REPOSITORY="${PROJECT_SOURCE_DIR}"
    PATH_WORKER="$<TARGET_FILE:lcpbench-worker-path>" STAND_IN_4="$<TARGET_FILE:path_stand_in_4>"
    STAND_IN_5="$<TARGET_FILE:path_stand_in_5>")
lcpbench_test(adapter_conventions)
lcpbench_test(adapter_friction)
lcpbench_test(adapter_hostile)
lcpbench_test(adapter_cone)
lcpbench_test(large_scenes SLOW APART OPTIMIZED LINK lcpbench_study NEEDS lcpbench_workers)
lcpbench_test(velocity_ipm_cholmod)

# PATH, played by stand-ins with the two layouts of its structures.
foreach(version 4 5)
  add_library(path_stand_in_${version} MODULE adapters/path_stand_in.cpp)
  target_compile_definitions(path_stand_in_${version} PRIVATE STAND_IN_VERSION=${version})
endforeach()
lcpbench_test(adapter_path)

# Programs of a user's own: the example's, and one that misbehaves.
lcpbench_test(external APART AND external_safety
  WITH adapters/worker_empty_poll.cpp
  LINK lcpbench_study lcpbench_adapters lcpbench_generators lcpbench_solver_list lcpbench_external_json
  NEEDS lcpbench lcpbench-worker-external
  DEFINE EXTERNAL_WORKER="$<TARGET_FILE:lcpbench-worker-external>"
    EXTERNAL_FAULTS="${CMAKE_CURRENT_SOURCE_DIR}/adapters/external_faults.py"
    LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>" REPOSITORY="${PROJECT_SOURCE_DIR}")

# Engines that capture scenes.
foreach(test close_parts capture_command capture_files capture_rows external_engine engine_solver)
  lcpbench_test(${test})
endforeach()
