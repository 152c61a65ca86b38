/* SPDX-License-Identifier: MIT */
/*
 * statue: a winged figure in a pleated robe on a round pedestal, after the Nike of Samothrace as far as a few dozen
 * distance functions go (Hart, "Sphere tracing", 1996; blending after Wyvill et al., 1986). The seed moves the arms,
 * the wings, the folds and the veins of the marble.
 */
#include "list.h"
#include "parts.h"
#include "polygonize.h"

#define FEATHERS 14

typedef struct tapered_limb {
    vector3 from, to;
    double radius_from, radius_to;
} tapered_limb;

typedef struct statue_pose {
    tapered_limb right_upper_arm, right_forearm, left_upper_arm, left_forearm;
    tapered_limb wing_bones[2];
    tapered_limb feathers[FEATHERS];
    vector3 orb;
    double twist; /* turns of the robe's folds per unit of height */
    uint32_t seed;
} statue_pose;

/* Blends two solids over a seam of the given width. */
static double join(double a, double b, double seam)
{
    const double overlap = clamp_to(1 - fabs(a - b) / seam, 0, 1);
    return (a < b ? a : b) - 0.25 * overlap * overlap * seam;
}

static double ball_distance(vector3 p, vector3 center, double radius)
{
    return vector_length(vector_subtract(p, center)) - radius;
}

static double ellipsoid_distance(vector3 p, vector3 center, vector3 radii)
{
    const vector3 q = vector_subtract(p, center);
    const vector3 scaled = vector(q.x / radii.x, q.y / radii.y, q.z / radii.z);
    const double smallest =
        radii.x < radii.y ? (radii.x < radii.z ? radii.x : radii.z) : (radii.y < radii.z ? radii.y : radii.z);
    return (vector_length(scaled) - 1) * smallest;
}

static double limb_distance(vector3 p, const tapered_limb *limb)
{
    const vector3 along = vector_subtract(limb->to, limb->from);
    const vector3 q = vector_subtract(p, limb->from);
    const double t = clamp_to(vector_dot(q, along) / vector_dot(along, along), 0, 1);
    return vector_length(vector_subtract(q, vector_scale(along, t))) - mix(limb->radius_from, limb->radius_to, t);
}

/* A drum around the vertical axis with rounded rims. */
static double drum_distance(vector3 p, double radius, double low, double high, double rim)
{
    const double outwards = sqrt(p.x * p.x + p.z * p.z) - radius + rim;
    const double upwards = fabs(p.y - 0.5 * (low + high)) - 0.5 * (high - low) + rim;
    const double out_clear = outwards > 0 ? outwards : 0;
    const double up_clear = upwards > 0 ? upwards : 0;
    const double inner = outwards > upwards ? outwards : upwards;
    return (inner < 0 ? inner : sqrt(out_clear * out_clear + up_clear * up_clear)) - rim;
}

/* cos(count * angle of (x, z) + shift turns), by a power of a unit complex number; no arc tangent needed. */
static double ripple(double x, double z, unsigned count, double shift_turns)
{
    const double radius = sqrt(x * x + z * z);
    double power_real = radius > 0 ? x / radius : 1;
    double power_imaginary = radius > 0 ? z / radius : 0;
    double real = cosine_of_turns(shift_turns);
    double imaginary = sine_of_turns(shift_turns);
    for (; count > 0; count >>= 1) {
        if ((count & 1u) != 0) {
            const double next = real * power_real - imaginary * power_imaginary;
            imaginary = real * power_imaginary + imaginary * power_real;
            real = next;
        }
        const double square = power_real * power_real - power_imaginary * power_imaginary;
        power_imaginary = 2 * power_real * power_imaginary;
        power_real = square;
    }
    return real;
}

/* How far p lies outside a box, along the axis where that is most; negative inside. */
static double box_gap(vector3 p, vector3 low, vector3 high)
{
    const double x = fabs(p.x - 0.5 * (low.x + high.x)) - 0.5 * (high.x - low.x);
    const double y = fabs(p.y - 0.5 * (low.y + high.y)) - 0.5 * (high.y - low.y);
    const double z = fabs(p.z - 0.5 * (low.z + high.z)) - 0.5 * (high.z - low.z);
    const double wider = x > y ? x : y;
    return wider > z ? wider : z;
}

static double pedestal_distance(vector3 p)
{
    const double angle_fade = smooth_ramp(0.1, 0.3, sqrt(p.x * p.x + p.z * p.z));
    const double flutes = 0.012 * angle_fade * ripple(p.x, p.z, 20, 0);
    double solid = drum_distance(p, 0.50, 0, 0.09, 0.015);
    solid = join(solid, drum_distance(p, 0.44, 0.05, 0.15, 0.02), 0.02);
    solid = join(solid, drum_distance(p, 0.37, 0.10, 0.50, 0.02) + flutes, 0.04);
    return join(solid, drum_distance(p, 0.42, 0.47, 0.55, 0.025), 0.03);
}

static double robe_distance(const statue_pose *pose, vector3 p)
{
    /* The hem sways to the figure's left and back, as in wind. */
    const double drop = smooth_ramp(1.35, 0.55, p.y);
    const double x = p.x - 0.03 * drop;
    const double z = p.z * 1.15 + 0.05 * drop;
    const double radius = sqrt(x * x + z * z);
    const double waist = mix(0.125, 0.27, drop) - 0.035 * smooth_ramp(0.06, 0, fabs(p.y - 1.30));
    const double fade = smooth_ramp(0.04, 0.14, radius);
    const double swirl = pose->twist * (p.y - 0.55);
    const double folds = 0.020 * drop * ripple(x, z, 9, swirl) + 0.010 * drop * ripple(x, z, 16, 0.3 - 1.7 * swirl);
    const double side = radius - waist - fade * folds;
    const double below = 0.53 - p.y;
    const double above = p.y - 1.48;
    const double caps = below > above ? below : above;
    return -join(-side, -caps, 0.05);
}

static double bust_distance(vector3 p)
{
    double solid = ellipsoid_distance(p, vector(0, 1.50, 0), vector(0.165, 0.17, 0.115));
    solid = join(solid, ellipsoid_distance(p, vector(0, 1.585, -0.005), vector(0.215, 0.07, 0.09)), 0.06);
    const vector3 mirrored = vector(fabs(p.x), p.y, p.z);
    solid = join(solid, ball_distance(mirrored, vector(0.068, 1.515, 0.082), 0.062), 0.04);
    const tapered_limb neck = {vector(0, 1.58, 0), vector(0, 1.76, 0.02), 0.06, 0.05};
    return join(solid, limb_distance(p, &neck), 0.06);
}

static double head_distance(vector3 p)
{
    double solid = ellipsoid_distance(p, vector(0, 1.83, 0.035), vector(0.078, 0.108, 0.092));
    const tapered_limb nose = {vector(0, 1.85, 0.118), vector(0, 1.815, 0.138), 0.008, 0.014};
    solid = join(solid, limb_distance(p, &nose), 0.03);
    const vector3 eye = vector(fabs(p.x) - 0.032, p.y - 1.848, p.z - 0.128);
    return -join(-solid, vector_length(eye) - 0.012, 0.03);
}

static double hair_distance(vector3 p)
{
    const double waves = 0.008 * sine_of_turns(14 * p.y + 5 * fabs(p.x)) + 0.004 * sine_of_turns(30 * p.x);
    double solid = ellipsoid_distance(p, vector(0, 1.865, 0.005), vector(0.098, 0.105, 0.105)) + waves;
    const double face = 0.045 - (p.z - 0.55 * (p.y - 1.80)); /* the hairline leans back */
    solid = -join(-solid, face, 0.03);
    return join(solid, ball_distance(p, vector(0, 1.89, -0.115), 0.055) + waves, 0.04);
}

static double arms_distance(const statue_pose *pose, vector3 p)
{
    const double right = join(limb_distance(p, &pose->right_upper_arm), limb_distance(p, &pose->right_forearm), 0.03);
    const double left = join(limb_distance(p, &pose->left_upper_arm), limb_distance(p, &pose->left_forearm), 0.03);
    return right < left ? right : left;
}

static double wings_distance(const statue_pose *pose, vector3 p)
{
    const vector3 mirrored = vector(fabs(p.x), p.y, p.z);
    double solid =
        join(limb_distance(mirrored, &pose->wing_bones[0]), limb_distance(mirrored, &pose->wing_bones[1]), 0.05);
    for (int k = 0; k < FEATHERS; ++k) {
        solid = join(solid, limb_distance(mirrored, &pose->feathers[k]), 0.022);
    }
    return solid;
}

/* A part whose box is farther away than any seam is represented by the gap, which never exceeds its distance: most
   points are far from most parts. */
#define FAR_GAP 0.12

static double figure_distance(const statue_pose *pose, vector3 p)
{
    const double gap = box_gap(p, vector(-0.62, 1.15, -0.25), vector(0.62, 2.2, 0.35));
    if (gap > FAR_GAP) {
        return gap;
    }
    double solid = join(bust_distance(p), arms_distance(pose, p), 0.035);
    solid = join(solid, head_distance(p), 0.025);
    solid = join(solid, hair_distance(p), 0.012);
    return join(solid, ball_distance(p, pose->orb, 0.065), 0.012);
}

static double statue_field(const void *context, vector3 p)
{
    const statue_pose *pose = context;
    const double robe_gap = box_gap(p, vector(-0.36, 0.5, -0.36), vector(0.40, 1.5, 0.30));
    const double wings_gap = box_gap(p, vector(-1.25, 1.05, -0.60), vector(1.25, 2.12, 0));
    const double pedestal_gap = p.y - 0.55;
    const double robe = robe_gap > FAR_GAP ? robe_gap : robe_distance(pose, p);
    const double wings = wings_gap > FAR_GAP ? wings_gap : wings_distance(pose, p);
    const double pedestal = pedestal_gap > FAR_GAP ? pedestal_gap : pedestal_distance(p);
    return join(join(join(robe, figure_distance(pose, p), 0.05), wings, 0.04), pedestal, 0.015);
}

static vector3 marble(uint32_t seed, vector3 p, vector3 light, vector3 vein)
{
    const double bend = fractal_noise(seed, vector_scale(p, 3), 4);
    const double line = fabs(sine_of_turns(0.8 * p.x + 1.1 * p.y + 0.6 * p.z + 0.7 * bend));
    return vector_mix(vein, light, smooth_ramp(0, 0.35, line));
}

static vector3 robe_color(const statue_pose *pose, vector3 p)
{
    const bool hem = p.y < 0.62 || fabs(p.y - 1.30) < 0.022 || p.y > 1.585;
    const vector3 cloth = marble(pose->seed + 9u, p, vector(0.45, 0.58, 0.74), vector(0.30, 0.42, 0.62));
    return hem ? vector(0.86, 0.64, 0.25) : cloth;
}

static vector3 pedestal_color(const statue_pose *pose, vector3 p)
{
    const bool band = (p.y > 0.465 && p.y < 0.545) || (p.y > 0.085 && p.y < 0.15);
    const vector3 stone = marble(pose->seed + 5u, p, vector(0.24, 0.33, 0.31), vector(0.52, 0.62, 0.56));
    return band ? vector(0.86, 0.64, 0.25) : stone;
}

/* The color of the part whose surface is nearest. */
static vector3 statue_color(const void *context, vector3 p)
{
    const statue_pose *pose = context;
    const vector3 ivory = marble(pose->seed, p, vector(0.93, 0.89, 0.82), vector(0.74, 0.69, 0.64));
    const double robe = robe_distance(pose, p);
    const double bust = bust_distance(p);
    const bool dressed = p.y < 1.61; /* the neckline */
    const double cloth = dressed && bust < robe ? bust : robe;
    const double limbs = arms_distance(pose, p);
    const double skin = !dressed && bust < limbs ? bust : limbs;
    const double head = head_distance(p);
    const double hair = hair_distance(p);
    const double wings = wings_distance(pose, p);
    if (p.y < 0.56 && pedestal_distance(p) < robe) {
        return pedestal_color(pose, p);
    }
    if (ball_distance(p, pose->orb, 0.065) < 0.008) {
        return vector(0.86, 0.64, 0.25);
    }
    if (hair < head && hair < wings && hair < skin && p.y > 1.72) {
        return vector(0.46, 0.30, 0.20);
    }
    if (wings < skin && wings < cloth && wings < head) {
        const double tip = smooth_ramp(0.35, 1.0, fabs(p.x) + 0.5 * (1.6 - p.y));
        return vector_mix(ivory, vector(0.85, 0.56, 0.40), 0.8 * tip);
    }
    return dressed && cloth < skin ? robe_color(pose, p) : vector_mix(ivory, vector(0.93, 0.78, 0.66), 0.6);
}

/* Wing bones rise outwards and back; feathers hang from them in a fan, the outer ones longer. */
static void set_wings(statue_pose *pose, double spread)
{
    const vector3 root = vector(0.07, 1.50, -0.12);
    const vector3 bend = vector(0.40 + 0.06 * spread, 1.86, -0.26);
    const vector3 tip = vector(0.80 + 0.10 * spread, 2.02, -0.34);
    pose->wing_bones[0] = (tapered_limb){root, bend, 0.060, 0.050};
    pose->wing_bones[1] = (tapered_limb){bend, tip, 0.050, 0.030};
    for (int k = 0; k < FEATHERS; ++k) {
        const double t = (k + 0.5) / FEATHERS;
        const vector3 start = t < 0.5 ? vector_mix(root, bend, 2 * t) : vector_mix(bend, tip, 2 * t - 1);
        const double length = 0.30 + 0.45 * t;
        const double lean = 0.03 + 0.15 * t + 0.04 * spread;
        const vector3 sweep = vector_normalize(vector(lean * 2.4, -1, -0.25));
        pose->feathers[k] = (tapered_limb){start, vector_add(start, vector_scale(sweep, length)), 0.048, 0.030};
    }
}

static void set_pose(statue_pose *pose, uint32_t seed)
{
    random_stream stream = {.state = seed};
    const double lift = random_between(&stream, -0.05, 0.05);
    const double swing = random_between(&stream, -0.05, 0.05);
    const double spread = random_between(&stream, -1, 1);
    const vector3 elbow = vector(0.40, 1.66 + lift, 0.10 + swing);
    const vector3 hand = vector(0.45, 1.93 + lift, 0.20 + swing);
    pose->right_upper_arm = (tapered_limb){vector(0.18, 1.59, 0), elbow, 0.055, 0.042};
    pose->right_forearm = (tapered_limb){elbow, hand, 0.042, 0.028};
    pose->orb = vector_add(hand, vector(0.005, 0.085, 0.01));
    const vector3 left_elbow = vector(-0.35, 1.36 - lift, 0.02 - swing);
    const vector3 left_hand = vector(-0.20, 1.22, 0.17);
    pose->left_upper_arm = (tapered_limb){vector(-0.18, 1.59, 0), left_elbow, 0.055, 0.042};
    pose->left_forearm = (tapered_limb){left_elbow, left_hand, 0.042, 0.030};
    pose->twist = random_between(&stream, 0.25, 0.55);
    pose->seed = seed;
    set_wings(pose, spread);
}

void scene_statue(scene_builder *builder, const scene_request *request)
{
    statue_pose pose;
    set_pose(&pose, request->seed);
    const implicit_solid solid = {
        .field = statue_field,
        .color = statue_color,
        .context = &pose,
        /* Odd margins, so that flat faces do not lie on lattice planes. */
        .low = vector(-1.2371, -0.1193, -0.7919),
        .high = vector(1.2371, 2.2717, 0.7919),
        .steepness = 3,
    };
    polygonize_to_count(builder, &solid, request->triangles);
}
