// One point per sample. Decoding and projection come from the host, so that each formula stands in one place.
#version 450 core
layout(location = 0) in vec3 position;
uniform mat4 clipFromVolume;
uniform float pointSize;
flat out uint sampleId;

void main() {
  sampleId = uint(gl_VertexID);
  gl_Position = clipFromVolume * vec4(position, 1.0);
  gl_PointSize = pointSize;
}
