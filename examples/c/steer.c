/* Three spheres on two rods that learn no more than this: the four half strokes of Najafi and Golestanian, in a row.
 *
 *   cc -Iin_process examples/c/steer.c -Lbuild/bin -Wl,-rpath,build/bin -lcopepod -o steer
 *   ./steer configs/examples/prescribed_stroke.yaml
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "copepod.h"

#define STEPS 2500   /* of one half stroke */
#define STROKE 16e-6 /* m */

static void require(int code) {
  if (code == 0) return;
  fprintf(stderr, "%s\n", copepod_error());
  exit(code);
}

static double middle_m(int64_t simulation) {
  copepod_state now;
  require(copepod_observe(simulation, &now));
  double sum_m = 0;
  for (int64_t body = 0; body < now.bodies; ++body) sum_m += now.position_m[3 * body + 2];
  return sum_m / (double)now.bodies;
}

int main(int argc, char** argv) {
  int64_t simulation;
  if (argc != 2) {
    fprintf(stderr, "usage: steer CASE\n");
    return COPEPOD_MISUSE;
  }
  require(copepod_open(argv[1], NULL, NULL, &simulation));
  const double rods_m[4][2] = {{-STROKE, 0}, {-STROKE, -STROKE}, {0, -STROKE}, {0, 0}};
  for (int cycle = 0; cycle < 2; ++cycle) {
    const double before_m = middle_m(simulation);
    for (int part = 0; part < 4; ++part) {
      for (int rod = 0; rod < 2; ++rod) require(copepod_act(simulation, rod, rods_m[part][rod], STEPS));
      require(copepod_step(simulation, STEPS, 0, NULL));
    }
    printf("cycle %d: %+.4f um\n", cycle, 1e6 * (middle_m(simulation) - before_m));
  }
  return copepod_close(simulation);
}
