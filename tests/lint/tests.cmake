# Linters, as ./run-tests installs them; each is skipped where it is missing.
set(tools ${PROJECT_SOURCE_DIR}/build/nanobind)
add_test(NAME lint_python WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
         COMMAND sh -c "test -x $1/bin/ruff || exit 77; exec $1/bin/ruff check --no-cache ." sh ${tools})
add_test(NAME lint_page WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}/study/report/page
         COMMAND sh -c "test -d $1/node_modules/eslint || exit 77; exec node $1/node_modules/eslint/bin/eslint.js src" sh
                 ${tools})
add_test(NAME lint_cpp WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
         COMMAND sh -c "command -v clang-tidy || exit 77; exec clang-tidy --quiet $* -- -std=c++20 -I. -isystem $EIGEN" sh
                 core/spec.cpp core/utf8.cpp core/suggestion.cpp core/settings.cpp)
get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
set_tests_properties(lint_cpp PROPERTIES ENVIRONMENT "EIGEN=${eigen}" COST 25)
set_tests_properties(lint_python lint_page lint_cpp PROPERTIES SKIP_RETURN_CODE 77 LABELS lint)
