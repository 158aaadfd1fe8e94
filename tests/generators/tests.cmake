# The same bits everywhere: the generators' own sources, built apart from the library by each compiler at hand, without
# and with optimisation, and for this processor; each program must print the hashes that are committed.
set(golden_sources
  tests/generators/golden_hashes.cpp generators/paper/paper.cpp generators/planted.cpp generators/random.cpp generators/rigid/rigid.cpp
  generators/paper/spectrum.cpp core/settings.cpp core/spec.cpp core/suggestion.cpp
  core/utf8.cpp generators/hard/applications.cpp generators/hard/boxes.cpp generators/hard/build.cpp generators/hard/chains.cpp
  generators/hard/classes.cpp generators/hard/conditioning.cpp generators/hard/edge.cpp generators/hard/hard.cpp
  generators/hard/particles.cpp generators/hard/pivoting.cpp generators/made/machines.cpp generators/made/made.cpp
  generators/made/masonry.cpp generators/made/piles.cpp generators/made/rows_and_nets.cpp generators/made/scene.cpp
  generators/rest/rest.cpp generators/rest/scene.cpp)

# One file that includes them all, so that each build reads their headers once.
list(TRANSFORM golden_sources REPLACE "(.+)" "#include \"\\1\"\n" OUTPUT_VARIABLE golden_includes)
list(JOIN golden_includes "" golden_includes)
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/golden/all.cpp @ONLY CONTENT "@golden_includes@")

function(lcpbench_golden variant compiler)
  set(directory ${CMAKE_CURRENT_BINARY_DIR}/golden/${variant})
  file(MAKE_DIRECTORY ${directory})
  set(object ${directory}/all.o)
  add_custom_command(
    OUTPUT ${object}
    COMMAND ${CMAKE_CXX_COMPILER_LAUNCHER} ${compiler} -std=c++20 ${ARGN} -ffp-contract=off -I${PROJECT_SOURCE_DIR}
            -idirafter ${RANDOM123_INCLUDE_DIR} -MD -MF ${object}.d -MT ${object}
            -c ${CMAKE_CURRENT_BINARY_DIR}/golden/all.cpp -o ${object}
    DEPENDS ${CMAKE_CURRENT_BINARY_DIR}/golden/all.cpp
    DEPFILE ${object}.d
    COMMENT "Golden hashes, ${variant}: compiling"
    VERBATIM)
  add_custom_command(
    OUTPUT ${directory}/golden_hashes
    COMMAND ${compiler} ${object} -o ${directory}/golden_hashes
    DEPENDS ${object}
    COMMENT "Golden hashes, ${variant}: linking"
    VERBATIM)
  add_custom_target(golden_hashes_${variant} ALL DEPENDS ${directory}/golden_hashes)
  add_test(NAME golden_hashes_${variant}
           COMMAND ${directory}/golden_hashes ${CMAKE_CURRENT_SOURCE_DIR}/golden/hashes.txt)
endfunction()

# The sanitizers have nothing to add to programs that are built with flags of their own. When cross-compiling, the compilers
# at hand build for this machine, not for the target; the test golden_library compares the hashes there.
if(NOT LCPBENCH_SANITIZE AND NOT CMAKE_CROSSCOMPILING)
  find_program(GOLDEN_GXX g++)
  find_program(GOLDEN_CLANGXX clang++)
  foreach(family GXX CLANGXX)
    string(TOLOWER ${family} name)
    if(GOLDEN_${family})
      lcpbench_golden(${name}_O0 ${GOLDEN_${family}} -O0)
      lcpbench_golden(${name}_O3 ${GOLDEN_${family}} -O3)
    else()
      string(REPLACE "xx" "++" program ${name})
      message(WARNING "golden hashes: ${program} not found; its two builds are not tested")
    endif()
  endforeach()
  if(GOLDEN_GXX)
    # GCC 12 forms vfmaddsub from alternating sums of products, whatever -ffp-contract says.
    lcpbench_golden(gxx_native ${GOLDEN_GXX} -O3 -march=native -fno-tree-slp-vectorize)
  endif()
endif()

# Also against the judge, which lives in study/.
lcpbench_room(generators
  LINK lcpbench_attack lcpbench_evaluation lcpbench_generators lcpbench_io lcpbench_study lcpbench_solver_list
    Threads::Threads
  DEFINE GENERATORS_PAGE="${PROJECT_SOURCE_DIR}/docs/reference/generators.md"
    GOLDEN_HASHES="${CMAKE_CURRENT_SOURCE_DIR}/golden/hashes.txt")
foreach(test changed random paper_generator rigid_generator planted_generator made rest sets to_problem hard)
  lcpbench_test(${test})
endforeach()

# Nor do the library's own build options change a bit.
add_executable(golden_hashes_library generators/golden_hashes.cpp)
target_link_libraries(golden_hashes_library PRIVATE lcpbench_generators)
add_test(NAME golden_library COMMAND golden_hashes_library ${CMAKE_CURRENT_SOURCE_DIR}/golden/hashes.txt)
set_tests_properties(golden_library PROPERTIES LABELS generators)
