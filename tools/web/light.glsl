/* SPDX-License-Identifier: MIT */
/*
 * Light. Of shaded pictures, as in kernels/rays/shade.clh: a sun with shadows, and a sky that short rays look for. Of
 * pages with light, as in kernels/light/picture.cl: sources with shadows, and what cones gathered when the page was
 * made (tools/web/bake.c), without specular light.
 */

#define SOURCES_MAX 16
#define SOURCE_FAR  0.0 /* kind: all its light comes from one direction */
#define SOURCE_DISK 3.0 /* kind: shines by the cosine from its axis */
#define PI          3.14159265

uniform vec3 sun; /* towards it; unit */
uniform vec3 up;
uniform float occlusionRange; /* of the short rays, in cells */
uniform float pagePixel; /* the width of the cone of a pixel of the page, which several of a screen may share */

uniform int lightLevel; /* the last with baked light */
uniform float exposure;
uniform vec3 sky; /* radiance from outside */
uniform sampler2DArray skyMap; /* RGBA8: what comes on top of it by direction, rows from the zenith down */
uniform ivec2 skySize; /* its columns and rows; 0: there is none */
uniform int sourceCount;
uniform vec4 sourcePlace[SOURCES_MAX]; /* in cells; w: the kind */
uniform vec4 sourceDirection[SOURCES_MAX]; /* where the light goes, unit; w: the cosine where a spot ends */
uniform vec4 sourceValue[SOURCES_MAX]; /* for lengths in cells; w: the cosine up to which a spot is full */

/* How open the hemisphere above a point is, nearer voxels counting more: 0 .. 1. */
float openness(vec3 point, vec3 normal, float range)
{
    vec3 helper = abs(normal.y) < 0.7 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    vec3 side = normalize(cross(normal, helper));
    vec3 other = cross(normal, side);
    float open = 0.0;
    for (int k = 0; k < 4; ++k) {
        vec2 circle = k == 0 ? vec2(0.85, 0.2) : k == 1 ? vec2(-0.2, 0.85) : k == 2 ? vec2(-0.85, -0.2)
                                                                                    : vec2(0.2, -0.85);
        Hit hit;
        vec3 direction = normalize(0.6 * normal + circle.x * side + circle.y * other);
        Ray ray = Ray(point, direction, 0.12, range, uvec2(k, 4));
        open += castRay(ray, hit) ? hit.distance / range : 1.0;
    }
    return 0.25 * open;
}

vec3 faceNormal(Hit hit, vec3 direction)
{
    vec3 normal = vec3(0.0);
    normal[hit.axis] = direction[hit.axis] > 0.0 ? -1.0 : 1.0;
    return normal;
}

/*
 * The normal of the surface that voxels without normals stand for: of the plane through what eight rays beside this one
 * meet, three voxels away from it, by least squares. What they meet much nearer or farther belongs to another surface.
 * Faces alone would show the steps of the grid, whose patterns flicker where they are about as small as pixels.
 */
vec3 fittedNormal(Ray ray, Hit hit, float nodeWidth)
{
    vec3 helper = abs(ray.direction.y) < 0.7 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    vec3 side = normalize(cross(ray.direction, helper));
    vec3 other = cross(ray.direction, side);
    float reach = 3.0 * nodeWidth;
    float before = 4.0 * reach;
    vec3 begin = ray.origin + (hit.distance - before) * ray.direction;
    mat3 squares = mat3(1.0, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.01); /* of the ray; no slope without others */
    vec3 products = vec3(0.0);
    for (int k = 0; k < 8; ++k) {
        float angle = 0.25 * PI * float(k);
        vec3 place = vec3(1.0, cos(angle), sin(angle));
        Hit beside;
        vec3 from = begin + reach * (place.y * side + place.z * other);
        Ray parallel = Ray(from, ray.direction, 0.0, 2.0 * before, ray.set);
        if (castRay(parallel, beside) && abs(beside.distance - before) < 0.9 * before) {
            squares += outerProduct(place, place);
            products += (beside.distance - before) / reach * place;
        }
    }
    vec3 plane = inverse(squares) * products;
    return normalize(plane.y * side + plane.z * other - ray.direction);
}

/* The normal of voxels without one: the face's where they are so large that they are seen, in pixels of the page. */
vec3 voxelNormal(Ray ray, Hit hit, float nodeWidth)
{
    float seen = smoothstep(2.0, 4.0, nodeWidth / (pagePixel * max(hit.distance, 1.0)));
    vec3 face = faceNormal(hit, ray.direction);
    return seen >= 1.0 ? face : normalize(mix(fittedNormal(ray, hit, nodeWidth), face, seen));
}

/* The node's normal, else that of voxels; never pointing away from the eye. Sheets have two sides, so a normal that
   points clearly away is negated. One that points slightly away belongs to a silhouette; it is made perpendicular to
   the ray. */
vec3 shadingNormal(Ray ray, Hit hit, float nodeWidth)
{
    vec3 normal;
    if (!readNormal(hit.node, normal)) {
        normal = voxelNormal(ray, hit, nodeWidth);
    }
    float away = dot(normal, ray.direction);
    if (away > 0.7) {
        return -normal;
    }
    return away > 0.0 ? normalize(normal - away * ray.direction) : normal;
}

/* Stored colors are squared to linear light; without them the surface is of clay. */
vec3 albedoOf(Hit hit)
{
    vec3 color;
    return readColor(hit.node, color) ? color * color : vec3(0.6);
}

/* The light that reaches a point of a surface: the sky's, and the sun's unless it is occluded. */
vec3 lightAt(vec3 point, vec3 normal, float nodeWidth)
{
    float direct = max(dot(normal, sun), 0.0);
    Hit blocker;
    if (direct > 0.0 && castRay(Ray(point, sun, 0.0, FAR, uvec2(0, 1)), blocker)) {
        direct = 0.0;
    }
    float open = openness(point, normal, max(occlusionRange, 6.0 * nodeWidth));
    float sky = 0.5 + 0.5 * dot(normal, up);
    vec3 ambient = mix(vec3(0.30, 0.27, 0.25), vec3(0.52, 0.58, 0.68), sky) * mix(0.3, 1.0, open);
    return ambient + direct * vec3(1.05, 0.98, 0.86);
}

/* Linear reflectance, from colors by the sRGB curve. */
vec3 reflectanceOf(Hit hit)
{
    vec3 color;
    if (!readColor(hit.node, color)) {
        return vec3(0.6);
    }
    return mix(pow((color + 0.055) / 1.055, vec3(2.4)), color / 12.92, lessThanEqual(color, vec3(0.04045)));
}

/* Baked irradiance, between the eight nodes around a point. A surface has a share of the three directions that it
   faces; nodes that nothing of which faces a direction say nothing about it. */
vec3 bakedAt(vec3 point, vec3 normal, int level)
{
    float width = float(1 << (depth - level));
    vec3 place = point / width - 0.5;
    vec3 inside = fract(place);
    ivec3 faces = ivec3(0, 2, 4) + ivec3(lessThan(normal, vec3(0.0)));
    mat3 sums = mat3(0.0);
    vec3 weights = vec3(0.0);
    for (int k = 0; k < 8; ++k) {
        ivec3 corner = ivec3(k & 1, k >> 1 & 1, k >> 2);
        vec3 near = mix(1.0 - inside, inside, vec3(corner)) + 0.01;
        uint node;
        if (!findNode(ivec3(floor(place)) + corner, level, node)) {
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            vec3 irradiance;
            if (readLight(node, faces[axis], irradiance)) {
                sums[axis] += near.x * near.y * near.z * irradiance;
                weights[axis] += near.x * near.y * near.z;
            }
        }
    }
    vec3 shares = normal * normal * vec3(greaterThan(weights, vec3(0.0)));
    return sums * (shares / max(weights, 1e-9)) / max(shares.x + shares.y + shares.z, 1e-9);
}

/* Irradiance by a source, as kernels/light/direct.clh has it. */
vec3 irradianceBy(int source, vec3 point, vec3 normal, float nodeWidth)
{
    vec4 place = sourcePlace[source];
    vec4 direction = sourceDirection[source];
    vec3 to = place.w == SOURCE_FAR ? -direction.xyz : place.xyz - point;
    float squared = max(dot(to, to), 1e-20);
    float away = sqrt(squared);
    float facing = dot(normal, to) / away;
    float cosine = -dot(direction.xyz, to) / away;
    float share = place.w == SOURCE_FAR ? 1.0
        : (place.w == SOURCE_DISK ? max(cosine, 0.0)
                                  : smoothstep(direction.w, sourceValue[source].w, cosine)) / squared;
    Hit blocker;
    float range = place.w == SOURCE_FAR ? FAR : away - 2.0 * nodeWidth; /* the lamp's own voxels are not in its way */
    if (facing * share <= 0.0 || castRay(Ray(point, to / away, 0.0, range, uvec2(0, 1)), blocker)) {
        return vec3(0.0);
    }
    return facing * share * sourceValue[source].rgb;
}

vec3 skyTexel(ivec2 place)
{
    ivec2 inside = ivec2((place.x + skySize.x) % skySize.x, clamp(place.y, 0, skySize.y - 1));
    return unpackLight(texelFetch(skyMap, placeTexel(uint(inside.y * skySize.x + inside.x)), 0));
}

/* Radiance from outside along a direction, as kernels/light/sky.clh has it. */
vec3 skyAlong(vec3 direction)
{
    if (skySize.x == 0) {
        return sky;
    }
    float turn = atan(direction.x, -direction.z) / (2.0 * PI) + 0.5;
    vec2 place = vec2(turn, atan(length(direction.xz), direction.y) / PI) * vec2(skySize) - 0.5;
    ivec2 low = ivec2(floor(place));
    vec2 share = place - floor(place);
    vec3 above = mix(skyTexel(low), skyTexel(low + ivec2(1, 0)), share.x);
    vec3 below = mix(skyTexel(low + ivec2(0, 1)), skyTexel(low + ivec2(1, 1)), share.x);
    return sky + mix(above, below, share.y);
}

/* All irradiance of a lit page. inside: a point of the node, so that a node of baked light holds it; point: off it.
   What is too near and too small for the nodes of baked light, short rays find: it holds the light back, and reflects
   about half of it. */
vec3 irradianceAt(vec3 inside, vec3 point, vec3 normal, int level)
{
    int bakedLevel = min(level, lightLevel);
    float nodeWidth = float(1 << (depth - level));
    float range = max(float(1 << (depth - bakedLevel)), 6.0 * nodeWidth);
    vec3 sum = bakedAt(inside, normal, bakedLevel) * mix(0.5, 1.0, openness(point, normal, range));
    for (int source = 0; source < sourceCount; ++source) {
        sum += irradianceBy(source, point, normal, nodeWidth);
    }
    return sum;
}

/* From light to the share of white that a screen shows: up to a half as it is, above it rolls off towards 1. */
vec3 toneOf(vec3 light)
{
    return mix(light, 1.0 - 0.5 * exp(1.0 - 2.0 * light), greaterThan(light, vec3(0.5)));
}

/* The light of a pixel's last sample, reused by the next one: light is most of a picture's cost. */
struct Lit {
    vec3 point;
    vec3 normal; /* zero before the first */
    vec3 light;
};

vec3 shade(Ray ray, Hit hit, bool isLit, inout Lit lit)
{
    float nodeWidth = float(1 << (depth - hit.level));
    vec3 normal = shadingNormal(ray, hit, nodeWidth);
    /* Offset from the voxels' steps, so that a surface does not occlude itself. */
    vec3 point = ray.origin + ray.direction * (hit.distance - 0.5 * nodeWidth) + normal * (1.75 * nodeWidth);
    vec3 moved = point - lit.point;
    if (dot(normal, lit.normal) < 0.9 || dot(moved, moved) > 6.0 * nodeWidth * nodeWidth) {
        vec3 inside = ray.origin + ray.direction * (hit.distance + 0.1 * nodeWidth);
        lit = Lit(point, normal, isLit ? irradianceAt(inside, point, normal, hit.level)
                                       : lightAt(point, normal, nodeWidth));
    }
    return isLit ? toneOf(exposure / PI * reflectanceOf(hit) * lit.light) : toneOf(0.85 * albedoOf(hit) * lit.light);
}

/* How open a surface is: 16 rays, as many in each direction as light comes from there. */
vec3 showOpenness(Ray ray, Hit hit)
{
    float nodeWidth = float(1 << (depth - hit.level));
    vec3 normal = shadingNormal(ray, hit, nodeWidth);
    vec3 point = ray.origin + ray.direction * (hit.distance - 0.5 * nodeWidth) + normal * (1.75 * nodeWidth);
    vec3 helper = abs(normal.y) < 0.7 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    vec3 side = normalize(cross(normal, helper));
    vec3 other = cross(normal, side);
    float range = max(3.0 * occlusionRange, 6.0 * nodeWidth);
    float open = 0.0;
    for (int k = 0; k < 16; ++k) {
        float share = (float(k) + 0.5) / 16.0;
        float angle = 2.39996 * float(k);
        vec3 direction = sqrt(share) * (cos(angle) * side + sin(angle) * other) + sqrt(1.0 - share) * normal;
        Hit blocker;
        open += castRay(Ray(point, direction, 0.12, range, uvec2(k, 16)), blocker) ? blocker.distance / range : 1.0;
    }
    return vec3(open / 16.0);
}

/* Shaded pictures: the square root inverts the squares of albedoOf. */
vec3 encodeSquares(vec3 shown)
{
    return sqrt(clamp(shown, 0.0, 1.0));
}

/* The sRGB curve (IEC 61966-2-1). */
vec3 encodeLight(vec3 shown)
{
    vec3 share = clamp(shown, 0.0, 1.0);
    return mix(1.055 * pow(share, vec3(1.0 / 2.4)) - 0.055, 12.92 * share, lessThanEqual(share, vec3(0.0031308)));
}
