// Colours between vertices, as perspective has them.
#version 450 core
in vec4 vertexColor;
layout(location = 0) out vec4 seenColor;

void main() { seenColor = max(vertexColor, vec4(0.0)); }
