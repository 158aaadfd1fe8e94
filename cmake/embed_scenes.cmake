# lcpbench_embed_scenes(FOLDER OUTPUT): writes the source that holds every FAMILY/ENGINE.scenes of FOLDER in the program,
# by the assembler's .incbin, and the list of them. A family may be a folder in a folder.
function(lcpbench_embed_scenes folder output)
  file(GLOB files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*/*.scenes ${folder}/*/*/*.scenes)
  list(SORT files)
  set(declarations "")
  set(entries "")
  set(paths "")
  set(number 0)
  foreach(file IN LISTS files)
    string(REGEX REPLACE "\\.scenes$" "" name "${file}")
    set(symbol lcpbench_scenes_${number})
    file(SHA256 ${folder}/${file} hash)  # a compiler cache sees the source, and not what .incbin reads
    string(APPEND declarations
      "__asm__(\".pushsection .rodata /* ${hash} */\\n\"\n"
      "        \".global ${symbol}\\n${symbol}:\\n.incbin \\\"${folder}/${file}\\\"\\n\"\n"
      "        \".global ${symbol}_end\\n${symbol}_end:\\n.byte 0\\n.popsection\\n\");\n"
      "extern \"C\" const char ${symbol}[];\nextern \"C\" const char ${symbol}_end[];\n")
    string(APPEND entries
      "      {\"scene/${name}\", {${symbol}, static_cast<std::size_t>(${symbol}_end - ${symbol})}},\n")
    list(APPEND paths ${folder}/${file})
    math(EXPR number "${number} + 1")
  endforeach()
  file(CONFIGURE OUTPUT ${output} @ONLY CONTENT "// Written by cmake/embed_scenes.cmake.
#include \"generators/scenes/scenes.h\"

@declarations@
namespace lcpbench {

const std::vector<CollectedScene>& collected_scenes() {
  static const std::vector<CollectedScene> scenes{
@entries@  };
  return scenes;
}

}  // namespace lcpbench
")
  set_source_files_properties(${output} PROPERTIES OBJECT_DEPENDS "${paths}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${paths})
endfunction()
