// The depth image's vertices, one a sample, with its colour.
#version 450 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 color;  // linear, premultiplied
uniform mat4 clipFromVolume;
out vec4 vertexColor;

void main() {
  vertexColor = color;
  gl_Position = clipFromVolume * vec4(position, 1.0);
  gl_PointSize = 1.0;
}
