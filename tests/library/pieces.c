/* A run in pieces has the bits of `limber run`: pieces RESULTS DECK PIECES
 * RESULTS: what the program has written of the deck; PIECES: pauses, half of them at times of samples. Besides: a state that was
 * saved half way gives the same again, in the same run and in another. */
#include "check.h"
#include <hdf5.h>
#include <limber.h>

/* A dataset of numbers; the caller frees it */
static double *read_series(hid_t file, const char *path, size_t *count)
{
  hid_t set = H5Dopen2(file, path, H5P_DEFAULT), space = H5Dget_space(set);
  double *values;
  *count = (size_t)H5Sget_simple_extent_npoints(space);
  values = malloc((*count + 1) * sizeof *values);
  check(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0, path);
  H5Sclose(space);
  H5Dclose(set);
  return values;
}

/* Compares samples of a run, from one on, with those of the file */
static void compare(limber_run *run, const char *results, const char *when)
{
  hid_t file = H5Fopen(results, H5F_ACC_RDONLY, H5P_DEFAULT);
  int channels = limber_count(run, LIMBER_CHANNELS), i;
  size_t samples = (size_t)limber_sample_count(run), count, k;
  double *times = malloc((samples + 1) * sizeof *times), *values = malloc((samples * (size_t)channels + 1) * sizeof *values);
  double *wanted = read_series(file, "/time", &count);
  size_t first = count >= samples ? count - samples : 0;
  limber_samples(run, times, values);
  check(count >= samples && samples > 0, when);
  check(memcmp(times, wanted + first, samples * sizeof *times) == 0, "times of the samples");
  free(wanted);
  for (i = 0; i < channels; i++) {
    char path[600];
    size_t wrong = 0;
    snprintf(path, sizeof path, "/channels/%s", limber_name(run, LIMBER_CHANNELS, i));
    wanted = read_series(file, path, &count);
    for (k = 0; k < samples; k++)
      if (memcmp(&values[k * (size_t)channels + (size_t)i], &wanted[first + k], sizeof *wanted) != 0) wrong++;
    if (wrong > 0) printf("%s, %s: %zu of %zu samples differ\n", when, path, wrong, samples);
    check(wrong == 0, path);
    free(wanted);
  }
  free(times);
  free(values);
  H5Fclose(file);
}

/* Channels at the time of the run are those of the sample there */
static void compare_last(limber_run *run)
{
  int channels = limber_count(run, LIMBER_CHANNELS), samples = limber_sample_count(run);
  double *times, *values, *now;
  if (samples == 0) return;
  times = malloc((size_t)samples * sizeof *times);
  values = malloc((size_t)(samples * channels + 1) * sizeof *values);
  now = malloc((size_t)(channels + 1) * sizeof *now);
  limber_samples(run, times, values);
  check(limber_values(run, now) == LIMBER_OK, "values");
  if (!(times[samples - 1] < limber_time(run)))
    check(memcmp(now, values + (samples - 1) * channels, (size_t)channels * sizeof *now) == 0, "channels at a sample");
  free(times);
  free(values);
  free(now);
}

int main(int count, char **words)
{
  limber_run *run, *other;
  int pieces = count > 3 ? atoi(words[3]) : 0, whole = 0, i;
  double start, end;
  void *state = NULL;
  size_t size = 0;
  if (count < 4) return 2;
  run = limber_open(words[2], NULL);
  check(limber_status(run) == LIMBER_OK, limber_error(run));
  start = limber_time(run);
  end = limber_end_time(run);
  for (i = 1; i < pieces; i++) {
    double part = (double)i / pieces;
    if (i % 2 == 1) part += 0.31 / pieces;
    if (limber_is_complete(run)) break;
    check(limber_advance(run, start + (end - start) * part) == LIMBER_OK, limber_error(run));
    compare_last(run);
    if (i == pieces / 2 && !limber_is_complete(run)) {
      size = limber_save(run, NULL, 0);
      if (size > 0) {
        state = malloc(size);
        check(limber_save(run, state, size) == size, "the size of a state");
      } else {
        /* A deck whose only analysis is run as a whole */
        check(strstr(limber_error(run), "has come to its end at once") != NULL, limber_error(run));
        whole = 1;
      }
    }
  }
  check(limber_finish(run) == LIMBER_OK, limber_error(run));
  check(limber_is_complete(run), "the end");
  compare_last(run);
  compare(run, words[1], "in pieces");
  if (size > 0) {
    check(limber_restore(run, state, size) == LIMBER_OK, limber_error(run));
    check(limber_finish(run) == LIMBER_OK, limber_error(run));
    compare(run, words[1], "from a state");
    other = limber_open(words[2], "");
    check(limber_restore(other, state, size) == LIMBER_OK, limber_error(other));
    check(limber_finish(other) == LIMBER_OK, limber_error(other));
    compare(other, words[1], "from a state, anew");
    check(limber_sample_count(other) < limber_sample_count(run), "samples before a state are not in another run");
    limber_close(other);
    free(state);
  }
  check(pieces < 4 || whole || size > 0, "a state was saved");
  limber_close(run);
  return faults > 0;
}
