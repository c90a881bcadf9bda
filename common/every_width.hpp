// One body for every width of vector; the widest the machine has is taken when the program starts. For loops over plain
// arrays that the compiler can turn into vector code by itself.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define GRANARY_EVERY_WIDTH __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define GRANARY_EVERY_WIDTH
#endif
