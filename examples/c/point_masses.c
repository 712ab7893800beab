/* A body component whose main program is ours: point masses that forces of fixed direction drive, semi-implicit Euler.
 *
 *     v(n+1) = v(n) + (F + F_drive) h / m,   x(n+1) = x(n) + h v(n+1)
 *
 *   cc -Iin_process examples/c/point_masses.c -Lbuild/bin -Wl,-rpath,build/bin -lcopepod -o point_masses
 *   deploy/copepod conformance --role body -- ./point_masses
 *   deploy/copepod run CASE.yaml --body ./point_masses
 *
 * With such forces alone it runs every case whose drive needs no torques: the coupler lowers the others to them.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "copepod_component.h"

typedef struct {
  double mass_kg, position_m[3], velocity_m_per_s[3], orientation_wxyz[4], angular_velocity_rad_per_s[3];
} mass;

typedef struct {
  int body;
  double direction[3];
} actuator;

static mass* masses;
static actuator* actuators;
static int64_t body_count, actuator_count;
static double step_s;
static int64_t next_step;

static void require(int code) {
  if (code == 0) return;
  fprintf(stderr, "%s\n", copepod_error());
  exit(code);
}

static double number(const char* list, int64_t index, const char* name) {
  char path[100];
  double value = 0;
  if (index < 0)
    snprintf(path, sizeof path, "/%s", list);
  else
    snprintf(path, sizeof path, *name ? "/%s/%lld/%s" : "/%s/%lld", list, (long long)index, name);
  require(copepod_component_number(path, &value));
  return value;
}

static void numbers(const char* list, int64_t index, const char* name, int count, double* values) {
  char entry[60];
  for (int i = 0; i < count; ++i) {
    snprintf(entry, sizeof entry, "%s/%d", name, i);
    values[i] = number(list, index, entry);
  }
}

static int begin(const copepod_request* request) {
  double gravity[3];
  for (int i = 0; i < 3; ++i) gravity[i] = number("gravity_m_per_s2", i, "");
  if (gravity[0] != 0 || gravity[1] != 0 || gravity[2] != 0)
    return copepod_component_fail(70, "The case has gravity (which these masses neglect). Use another component.");
  step_s = number("step_s", -1, "");
  body_count = request->bodies;
  actuator_count = request->actuators;
  free(masses);  /* of a simulation that returns to an earlier state */
  free(actuators);
  next_step = 0;
  masses = calloc((size_t)body_count + 1, sizeof *masses);
  actuators = calloc((size_t)actuator_count + 1, sizeof *actuators);
  for (int64_t i = 0; i < body_count; ++i) {
    masses[i].mass_kg = number("bodies", i, "mass_kg");
    numbers("bodies", i, "position_m", 3, masses[i].position_m);
    numbers("bodies", i, "velocity_m_per_s", 3, masses[i].velocity_m_per_s);
    numbers("bodies", i, "orientation_wxyz", 4, masses[i].orientation_wxyz);
    numbers("bodies", i, "angular_velocity_rad_per_s", 3, masses[i].angular_velocity_rad_per_s);
  }
  for (int64_t i = 0; i < actuator_count; ++i) {
    actuators[i].body = (int)number("actuators", i, "body_A");
    numbers("actuators", i, "direction", 3, actuators[i].direction);
  }
  return 0;
}

static void advance(const copepod_request* request) {
  for (int64_t i = 0; i < body_count; ++i)
    for (int j = 0; j < 3; ++j)
      masses[i].velocity_m_per_s[j] += step_s / masses[i].mass_kg * request->force_N[3 * i + j];
  for (int64_t i = 0; i < actuator_count; ++i) {
    mass* driven = &masses[actuators[i].body];
    for (int j = 0; j < 3; ++j)
      driven->velocity_m_per_s[j] += step_s / driven->mass_kg * request->actuation[i] * actuators[i].direction[j];
  }
  for (int64_t i = 0; i < body_count; ++i)
    for (int j = 0; j < 3; ++j) masses[i].position_m[j] += step_s * masses[i].velocity_m_per_s[j];
  next_step = request->step + 1;
}

static void answer_motion(const copepod_request* request) {
  for (int64_t i = 0; i < body_count; ++i) {
    memcpy(request->position_m + 3 * i, masses[i].position_m, sizeof masses[i].position_m);
    memcpy(request->velocity_m_per_s + 3 * i, masses[i].velocity_m_per_s, sizeof masses[i].velocity_m_per_s);
    memcpy(request->orientation_wxyz + 4 * i, masses[i].orientation_wxyz, sizeof masses[i].orientation_wxyz);
    memcpy(request->angular_velocity_rad_per_s + 3 * i, masses[i].angular_velocity_rad_per_s,
           sizeof masses[i].angular_velocity_rad_per_s);
  }
}

static uint64_t digest(void) {
  uint64_t sum = 14695981039346656037u ^ (uint64_t)next_step;
  for (size_t i = 0; i < (size_t)body_count * sizeof *masses; ++i)
    sum = (sum ^ ((const unsigned char*)masses)[i]) * 1099511628211u;
  return sum;
}

static int save_to(const char* path) {
  const uint64_t sum = digest();
  FILE* file = fopen(path, "wb");
  int is_whole = file && fwrite(masses, sizeof *masses, (size_t)body_count, file) == (size_t)body_count &&
                 fwrite(&next_step, sizeof next_step, 1, file) == 1 && fwrite(&sum, sizeof sum, 1, file) == 1;
  if (file && fclose(file) != 0) is_whole = 0;
  return is_whole ? 0 : copepod_component_fail(73, "The state cannot be written (full disk?). Choose another place.");
}

static int restore_from(const char* path) {
  uint64_t sum = 0;
  FILE* file = fopen(path, "rb");
  const int is_whole = file && fread(masses, sizeof *masses, (size_t)body_count, file) == (size_t)body_count &&
                       fread(&next_step, sizeof next_step, 1, file) == 1 && fread(&sum, sizeof sum, 1, file) == 1 &&
                       fgetc(file) == EOF && sum == digest();
  if (file) fclose(file);
  return is_whole ? 0 : copepod_component_fail(73, "The state cannot be read (damaged?). Use another checkpoint.");
}

int main(int argc, char** argv) {
  copepod_request request;
  require(copepod_component_open(argc, argv, "body", "Point masses in C", "1.0",
                                 "motion:free shape:sphere actuator:world_force checkpoint snapshots "
                                 "neglects:torques neglects:periodic"));
  for (;;) {
    require(copepod_component_next(&request));
    switch (request.kind) {
      case COPEPOD_SETUP:
        require(begin(&request));
        break;
      case COPEPOD_STEP:
        advance(&request);
        answer_motion(&request);
        break;
      case COPEPOD_KINEMATICS:
        answer_motion(&request);
        *request.next_step = next_step;
        break;
      case COPEPOD_SAVE:
        require(save_to(request.text));
        break;
      case COPEPOD_RESTORE:
        require(restore_from(request.text));
        break;
      case COPEPOD_SUMMARISE:
        *request.digest = digest();
        break;
      default:
        free(masses);
        free(actuators);
        return request.code;
    }
  }
}
