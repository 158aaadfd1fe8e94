# The package for simulators.
lcpbench_room(package)
lcpbench_test(embedding APART LINK lcpbench::native)
target_include_directories(embedding_test PRIVATE ${PROJECT_SOURCE_DIR})

# The interface for C.
enable_language(C)
foreach(name IN ITEMS package/c_api_test.c ${PROJECT_SOURCE_DIR}/examples/embed/main.c)
  cmake_path(GET name STEM program)
  add_executable(c_${program} ${name})
  target_link_libraries(c_${program} PRIVATE lcpbench::native m)
  set_target_properties(c_${program} PROPERTIES COMPILE_OPTIONS "-std=c99;-pedantic-errors;-Wall;-Wextra;-Werror")  # not those for C++
  add_dependencies(package_tests c_${program})
  add_test(NAME c_${program} COMMAND c_${program})
endforeach()
set_tests_properties(c_main PROPERTIES PASS_REGULAR_EXPRESSION "speed 0\\.589702 m/s, force on a lower corner 0\\.8662 N")

# The example as it stands in the documents, in this build ...
add_executable(embedding_example ${PROJECT_SOURCE_DIR}/examples/embed/main.cpp)
target_link_libraries(embedding_example PRIVATE lcpbench::native)
add_test(NAME embedding_example COMMAND embedding_example)
set_tests_properties(embedding_example PROPERTIES
  PASS_REGULAR_EXPRESSION "speed 0\\.589702 m/s, g \\(sin - mu cos\\) = 0\\.589702 m/s"
  FAIL_REGULAR_EXPRESSION "ERROR: |runtime error")

# ... and as a project of its own that finds the installed package. Sanitizers would need their flags there too.
add_test(NAME embedding_install
         COMMAND ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR} -DEXAMPLE=${PROJECT_SOURCE_DIR}/examples/embed
                 -DWORK=${CMAKE_CURRENT_BINARY_DIR}/embedding_install -DCOMPILER=${CMAKE_CXX_COMPILER}
                 -DGENERATOR=${CMAKE_GENERATOR} -DREADELF=${CMAKE_READELF}
                 -P ${CMAKE_CURRENT_SOURCE_DIR}/package/embedding_install.cmake)
set_tests_properties(embedding_install PROPERTIES LABELS "slow;release-only")

# The package alone: no library of the study is looked for.
add_test(NAME embedding_native_only
         COMMAND ${CMAKE_COMMAND} -S ${PROJECT_SOURCE_DIR} -B ${CMAKE_CURRENT_BINARY_DIR}/embedding_native_only
                 -G ${CMAKE_GENERATOR} -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER} -DLCPBENCH_NATIVE_ONLY=ON
                 -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON
                 -DCMAKE_DISABLE_FIND_PACKAGE_SQLite3=ON -DCMAKE_DISABLE_FIND_PACKAGE_CLI11=ON
                 -DCMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON)
add_test(NAME embedding_docs
         COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_SOURCE_DIR}/package/embedding_docs.cmake)

# Debian packages, and the action for GitHub.
add_test(NAME debian_packages
         COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/package/debian_test.sh ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}
                 ${CMAKE_CURRENT_BINARY_DIR}/debian_packages)
set_tests_properties(debian_packages PROPERTIES LABELS "slow;release-only" SKIP_RETURN_CODE 77)
add_test(NAME github_action
         COMMAND python3 ${CMAKE_CURRENT_SOURCE_DIR}/package/action_test.py ${PROJECT_SOURCE_DIR} $<TARGET_FILE:lcpbench>)
set_tests_properties(github_action PROPERTIES SKIP_RETURN_CODE 77)
add_test(NAME version
         COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/package/version_test.sh ${PROJECT_SOURCE_DIR} $<TARGET_FILE:lcpbench>
                 ${PROJECT_VERSION})
# What no build reads.
foreach(what workflows recipe site)
  add_test(NAME packaging_${what}
           COMMAND python3 ${CMAKE_CURRENT_SOURCE_DIR}/package/packaging_test.py ${what} ${PROJECT_SOURCE_DIR})
  set_tests_properties(packaging_${what} PROPERTIES SKIP_RETURN_CODE 77)
endforeach()
