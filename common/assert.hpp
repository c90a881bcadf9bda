// Our own mistakes: checked in Debug, in tests and in the `audit` preset; never for what users or files can do.
#pragma once

#ifdef GRANARY_ASSERTS
#include <cstdio>
#include <cstdlib>
#define GRANARY_ASSERT(condition, ...)                                                                         \
  do {                                                                                                         \
    if (!(condition)) {                                                                                        \
      std::fprintf(stderr, "%s:%d: broken promise: %s  [%s]\n", __FILE__, __LINE__, #condition, #__VA_ARGS__); \
      std::abort();                                                                                            \
    }                                                                                                          \
  } while (false)
#else
#define GRANARY_ASSERT(condition, ...) \
  do {                                 \
    (void)sizeof(!(condition));        \
  } while (false)
#endif
