/* A fluid or body component in C, Fortran, Rust: a process that takes part in a run, with a main program of its own.
 *
 *     copepod_request request;
 *     int code = copepod_component_open(argc, argv, "fluid", "My fluid", "1.0", "solver:external shape:sphere");
 *     while (code == 0 && (code = copepod_component_next(&request)) == 0 && request.kind != COPEPOD_END)
 *       ...                                      do what is asked for, and fill in the arrays that are to be answered
 *     return code != 0 ? code : request.code;
 *
 * `next` sends what was filled in as the answer to the request before, and waits for another. Connection, pings, states
 * and the command line (--capabilities, --help) are the library's affair, in threads of its own. Every function returns
 * 0 or COPEPOD_MISUSE (64), which changes nothing; copepod_error() then has the message. One component per process; its
 * functions are called by one thread at a time, and all but open and next while a request waits for its answer.
 * docs/adding_a_component.md has what a fluid and a body are asked for.
 */
#ifndef COPEPOD_COMPONENT_H
#define COPEPOD_COMPONENT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
  COPEPOD_END,        /* the run is over, or there was none: end the process with `code` */
  COPEPOD_SETUP,      /* text: the setup as JSON, as in setup.proto; for numbers see copepod_component_number */
  COPEPOD_SAVE,       /* write the state to the new file `text` */
  COPEPOD_RESTORE,    /* read the state from the file `text` */
  COPEPOD_SUMMARISE,  /* answer: digest, a number that follows from all bits of the state */
  COPEPOD_EXCHANGE,   /* fluid: bodies that move so during `step`; answer: loads on them */
  COPEPOD_ADVANCE,    /* fluid: the long work of the step, after the loads were sent */
  COPEPOD_KINEMATICS, /* body; answer: motion at the start of the next step, and its number: next_step */
  COPEPOD_STEP        /* body: advance by `step` with these loads and actuators; answer: motion at its end */
};

/* Arrays live until the next call. The vectors of bodies follow each other, 3 or 4 numbers each; SI units, world frame.
 * What is to be answered holds NaN, and a run ends where one is left. */
typedef struct {
  int32_t kind;
  int32_t code;      /* of COPEPOD_END */
  int64_t step;      /* of COPEPOD_EXCHANGE and COPEPOD_STEP */
  int64_t bodies;    /* those with motion */
  int64_t loads;     /* those with loads: of a fluid also obstacles, behind the bodies */
  int64_t actuators; /* of a body */
  const char* text;
  double* position_m;
  double* orientation_wxyz;
  double* velocity_m_per_s;
  double* angular_velocity_rad_per_s;
  double* force_N;
  double* torque_N_m;
  const double* actuation; /* values of the actuators at the start of the step */
  uint64_t* digest;
  int64_t* next_step;
} copepod_request;

/* Starts a component with the command line of the process.
 * role      "fluid" or "body"
 * features  what it can do, as words of docs/protocol.md with blanks between them; with snapshots, COPEPOD_SETUP may
 *           come again and begins anew */
int copepod_component_open(int argc, char** argv, const char* role, const char* name, const char* version,
                           const char* features);

int copepod_component_next(copepod_request* request);

/* Answers the last request by a failure, which ends the run: problem (why). What to do.
 * code  70: the solver cannot continue; 73: a state cannot be written or read */
int copepod_component_fail(int code, const char* message);

/* A number of the setup by its path, as "/bodies/0/radius_m". */
int copepod_component_number(const char* path, double* value);

/* Shows that a long computation advances; to be called now and then in one that takes minutes. */
int copepod_component_report_progress(void);

/* Message of this thread's last call that failed. */
const char* copepod_error(void);

#ifdef __cplusplus
}
#endif

#endif
