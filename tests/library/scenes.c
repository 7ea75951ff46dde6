/* Several scenes at once, errors, inputs and parameters by the C interface: scenes INPUT EXAMPLES [one]
 * INPUT, EXAMPLES: folders with decks; one: without threads. */
#include "check.h"
#include <limber.h>
#include <math.h>
#include <pthread.h>

static char first_deck[1000], second_deck[1000], controlled_deck[1000];

/* Samples of a run: all channels of all samples; the caller frees them */
static double *samples_of(limber_run *run, size_t *count)
{
  size_t samples = (size_t)limber_sample_count(run), channels = (size_t)limber_count(run, LIMBER_CHANNELS);
  double *times = malloc((samples + 1) * sizeof *times), *values = malloc((samples * channels + 1) * sizeof *values);
  limber_samples(run, times, values);
  free(times);
  *count = samples * channels;
  return values;
}

static double *run_alone(const char *deck, size_t *count)
{
  limber_run *run = limber_open(deck, "");
  double *values;
  check(limber_finish(run) == LIMBER_OK, limber_error(run));
  values = samples_of(run, count);
  limber_close(run);
  return values;
}

struct task {
  const char *deck;
  double *values;
  size_t count;
};

static void *run_task(void *argument)
{
  struct task *task = argument;
  limber_run *run = limber_open(task->deck, "");
  int i;
  for (i = 1; i < 20; i++) limber_advance(run, limber_end_time(run) * i / 20);
  limber_finish(run);
  task->values = samples_of(run, &task->count);
  limber_close(run);
  return NULL;
}

static void compare(const double *a, size_t count_a, const double *b, size_t count_b, const char *what)
{
  check(count_a == count_b && count_a > 0, what);
  if (count_a == count_b) check(memcmp(a, b, count_a * sizeof *a) == 0, what);
}

/* Two scenes interleaved, and in two threads, give the bits of one after the other */
static void check_together(int threads)
{
  size_t count[2], counts[2];
  double *alone[2], *together[2];
  const char *decks[2];
  limber_run *runs[2];
  int i, k;
  decks[0] = first_deck;
  decks[1] = second_deck;
  for (k = 0; k < 2; k++) {
    alone[k] = run_alone(decks[k], &count[k]);
    runs[k] = limber_open(decks[k], "");
  }
  for (i = 1; i < 10; i++)
    for (k = 0; k < 2; k++)
      check(limber_advance(runs[k], limber_end_time(runs[k]) * i / 10) == LIMBER_OK, limber_error(runs[k]));
  for (k = 0; k < 2; k++) {
    check(limber_finish(runs[k]) == LIMBER_OK, limber_error(runs[k]));
    together[k] = samples_of(runs[k], &counts[k]);
    compare(alone[k], count[k], together[k], counts[k], "two scenes, interleaved");
    free(together[k]);
    limber_close(runs[k]);
  }
  if (threads) {
    struct task tasks[2];
    pthread_t workers[2];
    for (k = 0; k < 2; k++) {
      tasks[k].deck = decks[k];
      check(pthread_create(&workers[k], NULL, run_task, &tasks[k]) == 0, "a thread");
    }
    for (k = 0; k < 2; k++) {
      pthread_join(workers[k], NULL);
      compare(alone[k], count[k], tasks[k].values, tasks[k].count, "two scenes in two threads");
      free(tasks[k].values);
    }
  }
  for (k = 0; k < 2; k++) free(alone[k]);
}

static void check_message(limber_run *run, int status, const char *part)
{
  check(limber_status(run) == status, part);
  check(strstr(limber_error(run), part) != NULL, part);
  if (strstr(limber_error(run), part) == NULL) printf("instead: %s\n", limber_error(run));
}

/* Decks and calls that cannot be used; a run that fails */
static void check_errors(void)
{
  double value = 0.0, values[4];
  limber_run *run = limber_open("there_is_no_such.inp", "");
  check_message(run, LIMBER_REFUSED, "there_is_no_such.inp");
  check(limber_count(run, LIMBER_CHANNELS) == 0 && limber_sample_count(run) == 0, "a deck that is not there has no channels");
  check(limber_finish(run) == LIMBER_REFUSED && limber_values(run, &value) == LIMBER_REFUSED, "nor a motion");
  check(limber_save(run, NULL, 0) == 0 && limber_restore(run, values, 8) == LIMBER_REFUSED, "nor a state");
  limber_close(run);

  run = limber_open_text("*POINT MASS, NAME=bob, MAS=1\n*DYNAMICS, END=1\n", "wrong.inp", "");
  check_message(run, LIMBER_REFUSED, "wrong.inp:1:24");
  limber_close(run);

  run = limber_open(first_deck, "speed 3");
  check_message(run, LIMBER_REFUSED, "'speed 3' is not name=value");
  limber_close(run);

  run = limber_open(first_deck, "no-such=3");
  check_message(run, LIMBER_REFUSED, "no-such");
  limber_close(run);

  run = limber_open(first_deck, "");
  check(limber_status(run) == LIMBER_OK && limber_error(run)[0] == 0, "no error, no message");
  check(limber_advance(run, 1.0) == LIMBER_OK && limber_advance(run, 0.5) == LIMBER_REFUSED, "time does not go back");
  check(limber_advance(run, NAN) == LIMBER_REFUSED, "a time that is none");
  check(limber_set_input(run, "u", 1.0) == LIMBER_REFUSED, "a deck without inputs");
  check(limber_restore(run, values, 0) == LIMBER_REFUSED, "a state that is none");
  check(limber_name(run, LIMBER_CHANNELS, -1)[0] == 0 && limber_name(run, LIMBER_CHANNELS, 4)[0] == 0, "names beyond the list");
  check(limber_count(run, 7) == 0, "a list that there is not");
  check(limber_name(run, 7, 0)[0] == 0 && limber_unit(run, -1, 0)[0] == 0 && limber_meaning(run, 4, 0)[0] == 0, "names of no list");
  check(limber_advance(run, 2.0) == LIMBER_OK && limber_time(run) == 2.0, "errors of calls leave the run as it is");
  limber_close(run);

  run = limber_open_text("*POINT MASS, NAME=bob, MASS=1, X=1\n*JOINT, NAME=rod, TYPE=ROD, LENGTH=1\n bob, ground.origin\n*GRAVITY\n"
                         "*DYNAMICS, END=10, OUTPUTS=100, INTEGRATOR=ADAMS, TOLERANCE=1e-9, MAXIMUM STEPS=50\n*OUTPUT\n x(bob)\n",
                         "short.inp", "");
  check(limber_finish(run) == LIMBER_FAILED, "a run that fails");
  check_message(run, LIMBER_FAILED, "MAXIMUM STEPS=50 are used up");
  check(limber_sample_count(run) > 3 && limber_sample_count(run) < 101, "what was computed stays");
  check(limber_finish(run) == LIMBER_FAILED, "it cannot go on");
  limber_close(run);
  limber_close(NULL);
}

/* Names, units, parameters */
static void check_lists(void)
{
  limber_run *run = limber_open(controlled_deck, "reach=1.5\nweight=3");
  double values[4], *q = NULL, *v = NULL;
  int coordinates = limber_count(run, LIMBER_COORDINATES);
  check(limber_count(run, LIMBER_CHANNELS) == 4 && limber_count(run, LIMBER_INPUTS) == 1, "channels and inputs");
  check(strcmp(limber_name(run, LIMBER_INPUTS, 0), "u") == 0, "name of the input");
  check(strcmp(limber_name(run, LIMBER_CHANNELS, 3), "y_arm_tip") == 0, limber_name(run, LIMBER_CHANNELS, 3));
  check(strcmp(limber_unit(run, LIMBER_CHANNELS, 1), "rad/s") == 0, limber_unit(run, LIMBER_CHANNELS, 1));
  check(limber_meaning(run, LIMBER_CHANNELS, 1)[0] != 0, "meaning of a channel");
  check(strcmp(limber_time_unit(run), "s") == 0, limber_time_unit(run));
  check(limber_values(run, values) == LIMBER_OK && fabs(values[3] + 1.5) < 1e-12, "the parameter counts");
  check(coordinates > 4 && strcmp(limber_name(run, LIMBER_COORDINATES, 3), "arm.sin") == 0, "names of coordinates");
  q = malloc((size_t)coordinates * sizeof *q);
  v = malloc((size_t)coordinates * sizeof *v);
  limber_state(run, q, v);
  check(fabs(q[3] + 1.0) < 1e-12 && fabs(v[3]) < 1e-12, "the arm hangs at rest");
  free(q);
  free(v);
  limber_close(run);
}

/* An input: without gravity a torque of u turns a bar of inertia I by u t^2/2I */
static void check_inputs(void)
{
  const char *deck = "*RIGID BODY, NAME=bar, MASS=1, INERTIA=2\n*JOINT, NAME=pivot, TYPE=REVOLUTE\n bar.origin, ground.origin\n"
                     "*CONTROL, NAME=u, TYPE=INPUT, PERIOD=0.1\n 4\n*TORQUE, NAME=drive, BODY=bar\n output(u)\n"
                     "*DYNAMICS, END=1, OUTPUTS=10, TOLERANCE=1e-9\n*OUTPUT\n angle(bar), spin(bar), output(u)\n";
  limber_run *run = limber_open_text(deck, "bar.inp", ""), *other;
  double values[3], again[3], *first, *second;
  size_t size, count, counts;
  void *state;
  /* The line of the deck up to 0.5, then 10: spin 4*0.5/2 + 10*0.5/2 */
  check(limber_advance(run, 0.5) == LIMBER_OK, limber_error(run));
  limber_values(run, values);
  check(fabs(values[1] - 1.0) < 1e-9 && fabs(values[2] - 4.0) < 1e-12, "the line of the deck counts until an input is set");
  check(limber_set_input(run, "u", 10.0) == LIMBER_OK, limber_error(run));
  size = limber_save(run, NULL, 0);
  state = malloc(size);
  limber_save(run, state, size);
  check(limber_finish(run) == LIMBER_OK, limber_error(run));
  limber_values(run, values);
  check(fabs(values[1] - 3.5) < 1e-8 && fabs(values[2] - 10.0) < 1e-12, "an input counts from its time on");
  first = samples_of(run, &count);
  /* A state knows the inputs that were set */
  other = limber_open_text(deck, "bar.inp", "");
  check(limber_restore(other, state, size) == LIMBER_OK, limber_error(other));
  check(limber_finish(other) == LIMBER_OK, limber_error(other));
  limber_values(other, again);
  check(memcmp(values, again, sizeof values) == 0, "a state knows its inputs");
  limber_close(other);
  /* Set in between it counts from the next sample of the control on; pauses change no bit */
  other = limber_open_text(deck, "bar.inp", "");
  limber_advance(other, 0.13);
  limber_advance(other, 0.41);
  limber_advance(other, 0.45);
  limber_set_input(other, "u", 10.0);
  limber_advance(other, 0.47);
  limber_values(other, again);
  check(fabs(again[2] - 4.0) < 1e-12, "not before the next sample");
  check(limber_finish(other) == LIMBER_OK, limber_error(other));
  second = samples_of(other, &counts);
  compare(first, count, second, counts, "inputs and pauses");
  free(first);
  free(second);
  /* A state may be gone back to, and goes on with another input */
  check(limber_restore(other, state, size) == LIMBER_OK && limber_set_input(other, "u", -2.0) == LIMBER_OK, "another input");
  check(limber_finish(other) == LIMBER_OK, limber_error(other));
  limber_values(other, again);
  check(fabs(again[1] - 0.5) < 1e-8, "another input from a state on");
  /* Set before the first call it counts from the start on */
  limber_close(run);
  run = limber_open_text(deck, "bar.inp", "");
  limber_set_input(run, "u", 6.0);
  limber_finish(run);
  limber_values(run, values);
  check(fabs(values[1] - 3.0) < 1e-8, "an input from the start on");
  /* Of another deck */
  limber_close(other);
  other = limber_open(first_deck, "");
  check(limber_restore(other, state, size) == LIMBER_REFUSED, "a state of another deck");
  ((char *)state)[size - 9] ^= 1;
  check(limber_restore(other, state, size - 8) == LIMBER_REFUSED, "a state that is cut off");
  free(state);
  limber_close(other);
  limber_close(run);
}

/* Pauses within the last step of a motion that another one follows: a free mass moves by x = t */
static void check_two_motions(void)
{
  const char *deck = "*POINT MASS, NAME=bob, MASS=1, VX=1\n*DYNAMICS, END=1, OUTPUTS=2\n*DYNAMICS, END=2, OUTPUTS=2\n"
                     "*OUTPUT\n x(bob)\n";
  limber_run *run = limber_open_text(deck, "free.inp", ""), *other;
  double value, again, q[2], v[2];
  int i;
  check(limber_status(run) == LIMBER_OK, limber_error(run));
  for (i = 1; i < 40; i++) {
    size_t size;
    void *state;
    check(limber_advance(run, 0.05 * i) == LIMBER_OK, limber_error(run));
    limber_values(run, &value);
    limber_state(run, q, v);
    check(fabs(value - 0.05 * i) < 1e-9 && fabs(q[0] - 0.05 * i) < 1e-9 && fabs(v[0] - 1) < 1e-9, "a pause in two motions");
    if (fabs(value - 0.05 * i) > 1e-9) printf("x = %g at t = %g\n", value, 0.05 * i);
    size = limber_save(run, NULL, 0);
    check(size > 0, limber_error(run));
    state = malloc(size);
    limber_save(run, state, size);
    other = limber_open_text(deck, "free.inp", "");
    check(limber_restore(other, state, size) == LIMBER_OK, limber_error(other));
    limber_values(other, &again);
    check(again == value && limber_time(other) == limber_time(run), "a state in two motions");
    limber_close(other);
    free(state);
  }
  check(limber_finish(run) == LIMBER_OK && limber_sample_count(run) == 6, "samples of two motions");
  limber_close(run);
}

int main(int count, char **words)
{
  if (count < 3) return 2;
  snprintf(first_deck, sizeof first_deck, "%s/pendulum.inp", words[1]);
  snprintf(second_deck, sizeof second_deck, "%s/pid_arm.inp", words[1]);
  snprintf(controlled_deck, sizeof controlled_deck, "%s/controlled_arm.inp", words[2]);
  check(limber_version()[0] != 0, "version");
  check_together(count < 4);
  check_errors();
  check_lists();
  check_inputs();
  check_two_motions();
  return faults > 0;
}
