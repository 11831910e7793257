// Where the pixel's ray enters the sphere is how far away the fragment is: as intersectSphereFromOrigin() of ray_sphere.h.
#version 450 core
flat in uint sampleId;
flat in vec3 toCenter;
flat in float radius;
uniform vec3 right, up, forward;
uniform float edge;
uniform vec2 halfSize;
uniform float nearest;  // distance whose depth is 1
layout(location = 0) out uint seenSample;

void main() {
  precise vec2 offset = vec2(gl_FragCoord.x - halfSize.x, halfSize.y - gl_FragCoord.y) * edge;
  precise vec3 toPlane = forward + offset.x * right + offset.y * up;
  precise vec3 direction = toPlane / sqrt(dot(toPlane, toPlane));
  precise float along = dot(toCenter, direction);
  precise vec3 beside = toCenter - along * direction;
  precise float discriminant = radius * radius - dot(beside, beside);
  precise float outside = dot(toCenter, toCenter) - radius * radius;
  if (!(along > 0.0 && radius > 0.0 && discriminant >= 0.0 && outside > 0.0)) discard;
  precise float t = min(outside / (along + sqrt(discriminant)), along);
  gl_FragDepth = min(nearest / t, 1.0);
  seenSample = sampleId;
}
