// Four corners of what a sphere may cover, for each sphere: its tangents from the eye, on each axis of the picture (Mara, McGuire 2013).
#version 450 core
layout(location = 0) in vec4 sphere;  // centre and radius, volume units
uniform uint firstSample;  // of this call
uniform vec3 eye, right, up, forward;
uniform float edge;      // of a pixel at distance 1
uniform vec2 halfSize;   // of the picture, pixels
flat out uint sampleId;
flat out vec3 toCenter;
flat out float radius;

const float kMargin = 1.0;  // pixels: corners are rounded, fragments are exact

// Least and greatest slope of rays that touch a circle; far out where they do not end, and from inside it, where none do.
vec2 slopes(float beside, float before, float r) {
  float squared = beside * beside + before * before - r * r;
  if (!(squared > 0.0)) return vec2(-1e30, 1e30);
  float tangent = sqrt(squared);
  float low = before * tangent + beside * r, high = before * tangent - beside * r;
  return vec2(low > 0.0 ? (beside * tangent - before * r) / low : -1e30, high > 0.0 ? (beside * tangent + before * r) / high : 1e30);
}

void main() {
  sampleId = firstSample + uint(gl_InstanceID);
  toCenter = sphere.xyz - eye;
  float squaredDistance = dot(toCenter, toCenter);
  // As seenRadius() of ray_sphere.h.
  radius = sphere.w > 0.0 && 4.0 * sphere.w * sphere.w > squaredDistance ? 0.5 * sqrt(squaredDistance) : sphere.w;
  float before = dot(toCenter, forward);
  gl_Position = vec4(2.0, 2.0, 0.5, 1.0);  // nowhere
  if (!(before + radius > 0.0)) return;
  vec2 x = halfSize.x + slopes(dot(toCenter, right), before, radius) / edge;
  vec2 y = halfSize.y - slopes(dot(toCenter, up), before, radius).yx / edge;
  vec2 low = clamp(vec2(x.x, y.x) - kMargin, vec2(-2.0), 2.0 * halfSize + 2.0);
  vec2 high = clamp(vec2(x.y, y.y) + kMargin, vec2(-2.0), 2.0 * halfSize + 2.0);
  vec2 corner = vec2((gl_VertexID & 1) == 0 ? low.x : high.x, (gl_VertexID & 2) == 0 ? low.y : high.y) / halfSize - 1.0;
  gl_Position = vec4(corner.x, -corner.y, 0.5, 1.0);
}
