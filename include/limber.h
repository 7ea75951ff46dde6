/* limber: dynamics of planar flexible multibody systems. The C interface of liblimber.so; doc/library.md explains it.
 *
 *    limber_run *run = limber_open("pendulum.inp", "");
 *    if (limber_status(run) || limber_finish(run)) fprintf(stderr, "%s\n", limber_error(run));
 *    ...
 *    limber_close(run);
 *
 * Texts are UTF-8, end with a null character and belong to limber. Those of limber_error and limber_warnings live until the next
 * call with the same run, all others until limber_close. Indices begin with 0. Nothing is printed, and no call ends the process.
 * Several runs may be open. Each may be used by any thread; calls of several threads wait for each other. */
#ifndef LIMBER_H
#define LIMBER_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A deck that has been opened, and its motion so far */
typedef struct limber_run limber_run;

/* Status of a call: done; the deck or the call cannot be used; the run could not go on */
enum { LIMBER_OK = 0, LIMBER_REFUSED = 2, LIMBER_FAILED = 3 };

/* Lists of numbers that have names */
enum { LIMBER_CHANNELS = 0, LIMBER_SCALARS = 1, LIMBER_COORDINATES = 2, LIMBER_INPUTS = 3 };

/* Version of limber, as "0.1.0" */
const char *limber_version(void);

/* Opens a deck: a file, or a text with a name for messages; files that it includes are relative to the folder of that name.
 * settings: values of parameters in place of those of the deck, "name=value", one a line; empty or NULL: none.
 * Never NULL. If limber_status is not LIMBER_OK, limber_error has all errors of the deck, each with file:line:column. */
limber_run *limber_open(const char *path, const char *settings);
limber_run *limber_open_text(const char *text, const char *name, const char *settings);

/* Closes a run and frees all that belongs to it; NULL is nothing to close */
void limber_close(limber_run *run);

/* Status and message of the last call with this run that can fail; the message is empty if it did not */
int limber_status(const limber_run *run);
const char *limber_error(const limber_run *run);

/* Warnings of the deck, and of the motion once it is complete; empty if there are none */
const char *limber_warnings(limber_run *run);

/* Goes on to time t, or to the end of the run if that comes first; limber_finish: to the end. If it fails, all that it has
 * computed before stays. t is not before the time of the run. */
int limber_advance(limber_run *run, double t);
int limber_finish(limber_run *run);

/* Time of the run; its end; their unit; whether the end is reached (1) or not (0) */
double limber_time(const limber_run *run);
double limber_end_time(const limber_run *run);
const char *limber_time_unit(const limber_run *run);
int limber_is_complete(const limber_run *run);

/* Items of a list, LIMBER_CHANNELS, ...; their names, units and meanings (one line; may be empty) */
int limber_count(const limber_run *run, int list);
const char *limber_name(const limber_run *run, int list, int index);
const char *limber_unit(const limber_run *run, int list, int index);
const char *limber_meaning(const limber_run *run, int list, int index);

/* Channels at the time of the run; values has room for all channels */
int limber_values(limber_run *run, double *values);

/* Samples of the deck up to the time of the run: their number; their times (samples) and channels, those of the first sample
 * first (samples * channels) */
int limber_sample_count(limber_run *run);
void limber_samples(limber_run *run, double *times, double *values);

/* Scalars of the deck (*SCALAR), over all samples; of a complete run */
void limber_scalars(limber_run *run, double *values);

/* Coordinates at the time of the run and their rates; both have room for all of LIMBER_COORDINATES */
void limber_state(limber_run *run, double *q, double *v);

/* Sets a *CONTROL, TYPE=INPUT: it takes the value at its next samples, those at the time of the run among them */
int limber_set_input(limber_run *run, const char *name, double value);

/* Saves the state: writes it to the buffer if that has room for it. Returns its size in bytes; 0: it failed, see limber_error.
 * limber_restore goes to such a state, of this run or of another one of the same deck and settings, by the same limber. */
size_t limber_save(limber_run *run, void *buffer, size_t size);
int limber_restore(limber_run *run, const void *buffer, size_t size);

#ifdef __cplusplus
}
#endif

#endif
