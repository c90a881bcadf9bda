/* granary-stamp [SECONDS]: writes when it began and when it ends, in ns of the monotonic clock. The bench's task:
   linked statically, so that next to nothing lies between its start and its first line. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

static long long now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * 1000000000LL + time.tv_nsec;
}

int main(int argc, char** argv) {
  const long long begin = now();
  if (argc > 1) usleep((useconds_t)(atof(argv[1]) * 1e6));
  char text[64];
  const int length = snprintf(text, sizeof text, "%lld %lld\n", begin, now());
  return write(1, text, (size_t)length) == length ? 0 : 1;
}
