/* libcopepod: a run inside another program, step by step, with all ranks of the fluid as threads of its process, or
 * with services.
 *
 * Every function returns 0, or the exit code of `copepod run` for the same failure (2: bad case, 70: diverged, 73:
 * disk), or COPEPOD_MISUSE; copepod_error() then has the message. No exception and no signal handler crosses the
 * border. Any number of simulations may be open, each in one call at a time; calls for different ones may come from
 * different threads. Same case, same calls: the same bits, for any number of ranks. Lengths in m, times in s; the
 * vectors of bodies follow each other, 3 or 4 numbers each. The first copepod_open silences spdlog's default logger; a
 * host that uses that one sets it afterwards.
 */
#ifndef COPEPOD_H
#define COPEPOD_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define COPEPOD_MISUSE 64 /* a handle, an argument or an order of calls that makes no sense; nothing has changed */

/* Opens a case at step 0.
 * settings   other values of some keys, "key.path=value" as after --set, ended by NULL; may be NULL. With
 *            "--endpoint=ADDRESS" and "--session=TOKEN" the solvers are services that the caller starts with these
 *            options (docs/protocol.md); "--keys=FILE": of the coupler, where other machines can connect; "--stop=N": a
 *            descriptor that ends the wait for the services, with code 143, once it can be read
 * directory  run directory that receives results; NULL: none are kept
 * simulation receives the handle */
int copepod_open(const char* case_file, const char* const* settings, const char* directory, int64_t* simulation);

/* Continues what is in a run directory, left by a simulation or by `copepod run`, from its newest checkpoint. What was
 * steered stays so. */
int copepod_resume(const char* directory, const char* const* settings, int64_t* simulation);

/* What does not change, as JSON: step_s, directory, warnings, names of "bodies", and "actuators" by their key path in
 * the case. The text lives until copepod_close. */
int copepod_describe(int64_t simulation, const char** json);

/* Advances by `steps`, or by fewer once `limit_s` of wall time have passed (at least one; 0: no limit).
 * done  receives the number of steps; may be NULL */
int copepod_step(int64_t simulation, int64_t steps, double limit_s, int64_t* done);

/* Motion at the start of the step that comes next, and the fluid's loads during the one before (0 before the first).
 * The arrays live until the next call for this simulation. */
typedef struct {
  int64_t step;
  int64_t bodies;
  const double* position_m;
  const double* orientation_wxyz;
  const double* velocity_m_per_s;
  const double* angular_velocity_rad_per_s;
  const double* force_N;
  const double* torque_N_m;
  int64_t flow_values; /* newest sample of output.flow, in the order of copepod_describe; before step 1 none */
  const double* flow;
} copepod_state;
int copepod_observe(int64_t simulation, copepod_state* state);

/* Figures of the last whole cycle of each swimmer and group, and of the swarm, as in summary.json: JSON that lives
 * until the next call of this function for this simulation. */
int copepod_cycles(int64_t simulation, const char** json);

/* Gives an actuator, counted from 0 in the order of copepod_describe, another value in place of the case's signal, from
 * the next step on: reached linearly within `steps` steps, at once if 0. Forces in N, torques in N m, rest lengths in m
 * beside the spring's, joints in rad or m since step 0, controls in the model's units; of a prescribed body the factor
 * of its velocities. */
int copepod_act(int64_t simulation, int64_t actuator, double value, int64_t steps);

/* Keeps the whole state in memory (fluid, bodies, coupler, actuators), returns to it any number of times, also after a
 * failure (but of a service), and frees it. What comes after has the bits of a run without interruption; files in the
 * run directory end where the state does. */
int copepod_snapshot(int64_t simulation, int64_t* snapshot);
int copepod_restore(int64_t simulation, int64_t snapshot);
int copepod_drop(int64_t simulation, int64_t snapshot);

/* Writes a checkpoint into the run directory; the newest two are kept. Not before the first step. */
int copepod_write_checkpoint(int64_t simulation);

/* Completes the run directory with summary.json, unless the simulation has failed, and frees everything. */
int copepod_close(int64_t simulation);

/* Message of this thread's last call that failed: problem (why). What to do. */
const char* copepod_error(void);

#ifdef __cplusplus
}
#endif

#endif
