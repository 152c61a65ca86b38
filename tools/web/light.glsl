/* SPDX-License-Identifier: MIT */
/* Light of a shaded picture, as in kernels/rays/shade.clh: a sun with shadows, and a sky that short rays look for. */

uniform vec3 sun; /* towards it; unit */
uniform vec3 up;
uniform float occlusionRange; /* of the short rays, in cells */

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
        Ray ray = Ray(point, normalize(0.6 * normal + circle.x * side + circle.y * other), 0.12, range);
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

/* The node's normal, else the face's; never pointing away from the eye. Sheets have two sides, so a normal that points
   clearly away is negated. One that points slightly away belongs to a silhouette; it is made perpendicular to the
   ray. */
vec3 shadingNormal(Hit hit, vec3 direction)
{
    vec3 normal;
    if (!readNormal(hit.node, normal)) {
        normal = faceNormal(hit, direction);
    }
    float away = dot(normal, direction);
    if (away > 0.7) {
        return -normal;
    }
    return away > 0.0 ? normalize(normal - away * direction) : normal;
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
    if (direct > 0.0 && castRay(Ray(point, sun, 0.0, FAR), blocker)) {
        direct = 0.0;
    }
    float open = openness(point, normal, max(occlusionRange, 6.0 * nodeWidth));
    float sky = 0.5 + 0.5 * dot(normal, up);
    vec3 ambient = mix(vec3(0.30, 0.27, 0.25), vec3(0.52, 0.58, 0.68), sky) * mix(0.3, 1.0, open);
    return ambient + direct * vec3(1.05, 0.98, 0.86);
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

vec3 shade(Ray ray, Hit hit, inout Lit lit)
{
    vec3 normal = shadingNormal(hit, ray.direction);
    float nodeWidth = float(1 << (depth - hit.level));
    /* Offset from the voxels' steps, so that a surface does not occlude itself. */
    vec3 point = ray.origin + ray.direction * (hit.distance - 0.5 * nodeWidth) + normal * (1.75 * nodeWidth);
    vec3 moved = point - lit.point;
    if (dot(normal, lit.normal) < 0.9 || dot(moved, moved) > 6.0 * nodeWidth * nodeWidth) {
        lit = Lit(point, normal, lightAt(point, normal, nodeWidth));
    }
    return toneOf(0.85 * albedoOf(hit) * lit.light);
}

/* The square root inverts the squares of albedoOf. */
vec3 encode(vec3 shown)
{
    return sqrt(clamp(shown, 0.0, 1.0));
}
