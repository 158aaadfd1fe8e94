# lcpbench_for_wheel(targets...): they bring the C++ library along, and run with glibc 2.34 or later. Not libgcc, whose
# static form needs glibc 2.35.
function(lcpbench_for_wheel)
  foreach(target IN LISTS ARGN)
    target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/python/older_glibc.cpp)
    target_link_options(${target} PRIVATE -static-libstdc++ LINKER:--exclude-libs,ALL LINKER:--wrap=hypot LINKER:--wrap=arc4random)
  endforeach()
endfunction()
