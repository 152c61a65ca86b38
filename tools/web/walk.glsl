/* SPDX-License-Identifier: MIT */
/*
 * Rays through the voxels: svo_cast of kernels/rays/voxels.clh, step by step, so that both stop at the same node. The
 * ray's cell is kept in integers; a step sets the crossed axis exactly and the other two from the ray, never backwards.
 */

/* The least component of a direction, so that crossings stay finite. */
#define DIRECTION_MIN 1e-20
#define FAR           1e30

uniform int depth; /* the grid has 2^depth cells per axis */
uniform int deepest; /* nodes of this level are not opened: 1 .. depth */

struct Ray {
    vec3 origin; /* in cells */
    vec3 direction; /* unit */
    float footprint; /* nodes smaller than footprint * distance are not opened */
    float range;
    uvec2 set; /* its number in a set of rays that see nodes by their alpha, and how many these are; 0: whole nodes */
};

struct Hit {
    float distance;
    uint node; /* breadth-first */
    int level;
    int axis; /* of the face that the ray entered through */
    int steps; /* cells visited */
};

float awayFromZero(float component)
{
    return abs(component) < DIRECTION_MIN ? DIRECTION_MIN : component;
}

ivec3 cellOf(vec3 point, ivec3 low, ivec3 high)
{
    return ivec3(clamp(floor(point), vec3(low), vec3(high)));
}

/* Where the ray is inside the grid: distances of entry and exit, and the axis of the entry. */
bool clipRay(Ray ray, vec3 inverse, float width, out float entry, out int axis)
{
    vec3 atLow = -ray.origin * inverse;
    vec3 atHigh = (width - ray.origin) * inverse;
    vec3 nearFaces = min(atLow, atHigh);
    vec3 farFaces = max(atLow, atHigh);
    float first = max(nearFaces.x, max(nearFaces.y, nearFaces.z));
    float last = min(farFaces.x, min(farFaces.y, farFaces.z));
    axis = first == nearFaces.x ? 0 : first == nearFaces.y ? 1 : 2;
    entry = max(first, 0.0);
    return last >= entry;
}

/* The octant of a node that holds a cell of the deepest level. shift: the node is 2^shift cells wide. */
uint octantOf(ivec3 cell, int shift)
{
    ivec3 bits = cell >> (shift - 1) & 1;
    return uint(bits.x | bits.y << 1 | bits.z << 2);
}

/* The number of binary digits of a number from 1 to 2^24: the exponent of a float that holds it exactly. */
int countDigits(int number)
{
    return (floatBitsToInt(float(number)) >> 23) - 126;
}

/* Whether a ray sees a node: kernels/rays/alpha.clh. The finalizer of MurmurHash3 hashes the cell. */
bool showsNode(uint node, ivec3 cell, uvec2 set)
{
    uint alpha = set.y == 0u ? 255u : readAlpha(node);
    if (alpha == 255u) {
        return true;
    }
    uint bits = uint(cell.x) * 73856093u ^ uint(cell.y) * 19349663u ^ uint(cell.z) * 83492791u;
    bits = (bits ^ bits >> 16) * 0x85ebca6bu;
    bits = (bits ^ bits >> 13) * 0xc2b2ae35u;
    uint turn = (bits ^ bits >> 16) % set.y;
    return 2u * alpha * set.y > (2u * ((set.x + turn) % set.y) + 1u) * 255u;
}

/* The first voxel along the ray. */
bool castRay(Ray ray, out Hit hit)
{
    int cells = 1 << depth;
    vec3 direction = vec3(awayFromZero(ray.direction.x), awayFromZero(ray.direction.y), awayFromZero(ray.direction.z));
    vec3 inverse = 1.0 / direction;
    ivec3 forward = ivec3(greaterThan(direction, vec3(0.0)));
    float t;
    int axis;
    hit = Hit(0.0, 0u, 0, 0, 0);
    if (!clipRay(ray, inverse, float(cells), t, axis)) {
        return false;
    }
    ivec3 cell = cellOf(ray.origin + t * direction, ivec3(0), ivec3(cells - 1));
    uint stack[17]; /* the nodes from the root to the ray's cell */
    stack[0] = 0u;
    int level = 0;
    int stepLimit = 3 * cells + 1;
    for (int passed = 0; passed < stepLimit && t <= ray.range; ++passed) {
        bool solid = false;
        ++hit.steps;
        /* Down to what holds the cell; otherwise its child on the level below is empty. */
        for (int opened = 0; opened <= deepest; ++opened) {
            int shift = depth - level;
            solid = level == deepest || (level > 0 && float(1 << shift) < ray.footprint * t);
            if (solid) {
                break;
            }
            uint child;
            int kind = openNode(stack[level], octantOf(cell, shift), child);
            solid = kind == CHILD_SELF;
            if (kind != CHILD_NODE) {
                break;
            }
            level += 1;
            stack[level] = child;
        }
        if (solid) {
            hit.distance = t;
            hit.axis = axis;
            hit.level = level;
            hit.node = stack[level];
            if (showsNode(hit.node, cell >> (depth - level), ray.set)) {
                return true;
            }
            level -= 1; /* as if it were empty */
        }
        /* Leave the empty cell by the nearest of its three far faces. */
        int width = 1 << (depth - level - 1);
        ivec3 low = cell & -width;
        vec3 crossing = (vec3(low + width * forward) - ray.origin) * inverse;
        axis = crossing.x <= crossing.y ? (crossing.x <= crossing.z ? 0 : 2) : (crossing.y <= crossing.z ? 1 : 2);
        t = max(t, min(crossing.x, min(crossing.y, crossing.z)));
        ivec3 along = cellOf(ray.origin + t * direction, low, low + width - 1);
        ivec3 next = forward * max(cell, along) + (1 - forward) * min(cell, along);
        next[axis] = low[axis] + (forward[axis] == 1 ? width : -1);
        ivec3 changed = cell ^ next;
        int difference = changed.x | changed.y | changed.z;
        if (difference < 0 || difference >= cells) {
            return false; /* a coordinate of -1 or beyond the last cell */
        }
        /* The deepest node that holds both cells. */
        level = min(level, depth - countDigits(difference));
        cell = next;
    }
    return false;
}
