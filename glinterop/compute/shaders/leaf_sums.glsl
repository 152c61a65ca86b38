/* SPDX-License-Identifier: MIT */
/* 64-bit sums of leaves, to which fragments add by 32-bit atomics: low word first, with a carry to the high one. */
#if defined(SVO_K_GATHER) || defined(SVO_K_AREA)

layout(std430, binding = 9) buffer Sums
{
    uint sum_words[];
};

void svo_add_sum(uint at, uint64_t number)
{
    uint word = 2u * at - svo_first[9];
    uint low = uint(number & uint64_t(0xffffffffu));
    uint before = atomicAdd(sum_words[word], low);
    uint high = uint(number >> 32) + (before + low < before ? 1u : 0u);
    if (high != 0u) {
        atomicAdd(sum_words[word + 1u], high);
    }
}

#endif
