// Which sample is seen; its colour is looked up afterwards, exactly.
#version 450 core
flat in uint sampleId;
layout(location = 0) out uint seenSample;

void main() { seenSample = sampleId; }
