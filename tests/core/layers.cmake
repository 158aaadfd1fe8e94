# Fails on an include that points upward, on folders that include each other, or on a name that is not spelled from the root. Run as: cmake -DROOT=<source> -P tests/core/layers.cmake
#
#   core  <-  generators, native, adapters  <-  study        tests may include everything
#   core  <-  study/evaluation  <-  study
#   native/auto/measure, programs that are no part of the tool, may include generators/ too
#
# Within a layer no folder may include itself by way of others. Files that lie directly in a layer are in no folder.
#
# One exception: one file of adapters/ may include native/velocity_ipm and native/answer_test. SuiteSparse's worker is
# that native method with CHOLMOD inside, so that it tests its answers as every native solver does, and CHOLMOD's licence
# keeps it out of everything but a worker (docs/decisions.md).
#
# Another: the programs that capture scenes include the header that users' own engines include, examples/capture.
#
cmake_minimum_required(VERSION 3.22)

# The evaluation knows core only, so that no verdict can depend on a solver or a generator.
set(allowed_core core)
set(allowed_generators core generators)
set(allowed_native core native)
set(allowed_adapters core adapters examples/capture)  # the header is for any engine
set(allowed_study core generators adapters study)
set(allowed_evaluation core study/evaluation)
set(capture_program adapters/capture/program.cpp)
set(native_method_file adapters/suitesparse/velocity_ipm_cholmod.cpp)

set(violations "")
set(folders "")
set(seen 0)
foreach(layer core generators native adapters study)
  file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/${layer}/*.h ${ROOT}/${layer}/*.cpp ${ROOT}/${layer}/*.inc)
  foreach(file IN LISTS files)
    math(EXPR seen "${seen} + 1")
    set(allowed ${allowed_${layer}})
    if(file MATCHES "^native/auto/measure/")
      list(APPEND allowed generators)
    endif()
    if(file MATCHES "^study/evaluation/")
      set(allowed ${allowed_evaluation})
    endif()
    if(file STREQUAL capture_program)
      list(APPEND allowed examples/capture)
    endif()
    if(file STREQUAL native_method_file)
      list(APPEND allowed native/velocity_ipm native/answer_test)
    endif()
    file(STRINGS ${ROOT}/${file} includes REGEX "^[ \t]*#[ \t]*include[ \t]+\"")
    foreach(include IN LISTS includes)
      string(REGEX REPLACE "^[^\"]*\"([^\"]*)\".*$" "\\1" target "${include}")
      set(fits FALSE)
      foreach(prefix IN LISTS allowed)
        if(target MATCHES "^${prefix}[/._]")
          set(fits TRUE)
        endif()
      endforeach()
      get_filename_component(from ${file} DIRECTORY)
      get_filename_component(to ${target} DIRECTORY)
      if(from MATCHES "/" AND to MATCHES "^${layer}/" AND NOT from STREQUAL to
         AND NOT to IN_LIST included_by_${from})
        list(APPEND folders ${from})
        list(APPEND included_by_${from} ${to})
        set(example_${from}_${to} "  ${file} includes \"${target}\": these folders include each other, maybe by way of others\n")
      endif()
      if(NOT fits)
        string(APPEND violations "  ${file} includes \"${target}\"; ${layer} may include: ${allowed}\n")
      endif()
    endforeach()
  endforeach()
endforeach()

# Folders that include no other one, or that no other one includes, are taken away until none is left but circles.
list(REMOVE_DUPLICATES folders)
set(removed TRUE)
while(removed)
  set(removed FALSE)
  set(included "")
  foreach(folder IN LISTS folders)
    list(APPEND included ${included_by_${folder}})
  endforeach()
  foreach(folder IN LISTS folders)
    set(free TRUE)
    foreach(target IN LISTS included_by_${folder})
      if(target IN_LIST folders)
        set(free FALSE)
      endif()
    endforeach()
    if(free OR NOT folder IN_LIST included)
      list(REMOVE_ITEM folders ${folder})
      set(removed TRUE)
    endif()
  endforeach()
endwhile()
foreach(folder IN LISTS folders)
  foreach(target IN LISTS included_by_${folder})
    if(target IN_LIST folders)
      string(APPEND violations ${example_${folder}_${target}})
    endif()
  endforeach()
endforeach()

# A name without its folder means another file to each reader and each compiler.
file(GLOB_RECURSE test_files RELATIVE ${ROOT} ${ROOT}/tests/*.h ${ROOT}/tests/*.cpp)
foreach(file IN LISTS test_files)
  file(STRINGS ${ROOT}/${file} includes REGEX "^[ \t]*#[ \t]*include[ \t]+\"[^/\"]+\"")
  foreach(include IN LISTS includes)
    string(APPEND violations "  ${file}: ${include}: includes are spelled from the root\n")
  endforeach()
endforeach()

# core and the public part of every layer stay free of foreign libraries: core knows Eigen and the standard library.
file(GLOB core_files RELATIVE ${ROOT} ${ROOT}/core/*.h ${ROOT}/core/*.cpp)
foreach(file IN LISTS core_files)
  file(STRINGS ${ROOT}/${file} includes REGEX "^[ \t]*#[ \t]*include[ \t]+<[A-Za-z0-9_]+/")
  foreach(include IN LISTS includes)
    if(NOT include MATCHES "<(Eigen|sys)/")
      string(APPEND violations "  ${file}: ${include}: core knows Eigen and the standard library only\n")
    endif()
  endforeach()
endforeach()

if(seen LESS 20)
  message(FATAL_ERROR "looked at only ${seen} files under '${ROOT}': wrong ROOT?")
endif()
if(violations)
  message(FATAL_ERROR "includes that break the layers:\n${violations}")
endif()
message(STATUS "layers hold in ${seen} files")
