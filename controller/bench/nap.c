/* granary-nap SECONDS: sleeps, and nothing else. Linked statically: what it takes beyond SECONDS is the kernel's and the
   pilot's, not the loading of libraries. */
#include <stdlib.h>
#include <time.h>

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? atof(argv[1]) : 0.0;
  struct timespec left = {(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * 1e9)};
  return nanosleep(&left, NULL) == 0 ? 0 : 1;
}
