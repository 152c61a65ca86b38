/* SPDX-License-Identifier: MIT */
/* Puts a corner of a triangle on the picture of a source. There is no depth: the fragment shader compares. */
layout(std430, binding = 0) readonly buffer Vertices
{
    int vertices[]; /* of each the snapped coordinates, and the bits of what these lack of the mesh's own, grid units */
};
layout(std430, binding = 1) readonly buffer Indices
{
    uint indices[];
};

flat out vec3 corner; /* the first, from the view's base */
flat out vec3 edge_b; /* to the second */
flat out vec3 edge_c; /* to the third */
flat out uint triangle;

ivec3 fetch(uint place)
{
    uint vertex = indices[place] * 6u;
    return ivec3(vertices[vertex], vertices[vertex + 1u], vertices[vertex + 2u]);
}

vec3 fetch_rest(uint place)
{
    uint vertex = indices[place] * 6u + 3u;
    return intBitsToFloat(ivec3(vertices[vertex], vertices[vertex + 1u], vertices[vertex + 2u]));
}

void main()
{
    uint first = uint(gl_VertexID) / 3u * 3u;
    ivec3 units = fetch(first);
    vec3 rest = fetch_rest(first);
    corner = vec3(units) - base.xyz + rest;
    edge_b = vec3(fetch(first + 1u) - units) + (fetch_rest(first + 1u) - rest);
    edge_c = vec3(fetch(first + 2u) - units) + (fetch_rest(first + 2u) - rest);
    vec3 place = gl_VertexID % 3 == 0 ? corner : gl_VertexID % 3 == 1 ? corner + edge_b : corner + edge_c;
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
    triangle = first / 3u;
}
