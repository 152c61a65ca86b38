/* SPDX-License-Identifier: MIT */
/* Puts a corner of a triangle on the picture of a source. There is no depth: the fragment shader compares. */
layout(std430, binding = 0) readonly buffer Vertices
{
    int vertices[];
};
layout(std430, binding = 1) readonly buffer Indices
{
    uint indices[];
};

flat out vec3 corner; /* the first, from the view's base */
flat out vec3 edge_b; /* to the second */
flat out vec3 edge_c; /* to the third */
flat out uint triangle;

vec3 fetch(uint place)
{
    uint vertex = indices[place] * 3u;
    return vec3(ivec3(vertices[vertex], vertices[vertex + 1u], vertices[vertex + 2u])) - base.xyz;
}

void main()
{
    uint first = uint(gl_VertexID) / 3u * 3u;
    vec3 a = fetch(first);
    vec3 b = fetch(first + 1u);
    vec3 c = fetch(first + 2u);
    vec3 place = gl_VertexID % 3 == 0 ? a : gl_VertexID % 3 == 1 ? b : c;
    float depth = forward.w != 0.0 ? 1.0 : dot(place, axis.xyz);
    float x = dot(place, right.xyz);
    float y = dot(place, up.xyz);
    if (forward.w == 0.0) {
        x -= depth * dot(forward.xyz, right.xyz);
        y -= depth * dot(forward.xyz, up.xyz);
    }
    float rows = float(band.y);
    float below = float(int(view.y) - 2 * int(band.x) - int(band.y));
    gl_Position = vec4(x / (right.w * float(view.x)), (y / up.w + depth * below) / rows, 0.0, depth);
    corner = a;
    edge_b = b - a;
    edge_c = c - a;
    triangle = first / 3u;
}
