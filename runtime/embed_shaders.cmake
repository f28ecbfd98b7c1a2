# SPDX-License-Identifier: Apache-2.0
# cmake -DOUTPUT=x.cpp "-DSHADERS=a.glsl;b.glsl" -P embed_shaders.cmake
# Writes a source file that holds the shaders as strings. Literals are cut into pieces that every compiler takes.
set(text "// Made by runtime/embed_shaders.cmake.\n#include \"runtime/src/embedded_shaders.h\"\n\nnamespace photic::runtime {\n\nconst EmbeddedShader kEmbeddedShaders[] = {\n")
foreach(shader ${SHADERS})
  get_filename_component(name ${shader} NAME)
  file(READ ${shader} content)
  string(APPEND text "    {\"${name}\",\n")
  string(LENGTH "${content}" length)
  set(start 0)
  while(start LESS length)
    string(SUBSTRING "${content}" ${start} 8000 piece)
    string(APPEND text "     R\"photic_glsl(${piece})photic_glsl\"\n")
    math(EXPR start "${start} + 8000")
  endwhile()
  string(APPEND text "    },\n")
endforeach()
string(APPEND text "    {nullptr, nullptr}};\n\n}  // namespace photic::runtime\n")
file(WRITE ${OUTPUT} "${text}")
