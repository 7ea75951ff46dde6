/* Opens a deck, steps it, and prints a channel. Build: cc pendulum.c $(pkg-config --cflags --libs limber) -o pendulum */
#include <limber.h>
#include <stdio.h>
#include <stdlib.h>

int main(int count, char **words)
{
  limber_run *run = limber_open(count > 1 ? words[1] : "pendulum.inp", "");
  int status = limber_status(run), steps = 10, i;
  double end = limber_end_time(run);
  if (status == LIMBER_OK) {
    double *values = malloc((size_t)limber_count(run, LIMBER_CHANNELS) * sizeof *values);
    for (i = 0; i <= steps && status == LIMBER_OK; i++) {
      status = limber_advance(run, end * i / steps);
      if (status == LIMBER_OK) status = limber_values(run, values);
      if (status == LIMBER_OK)
        printf("t = %g %s: %s = %.9g %s\n", limber_time(run), limber_time_unit(run), limber_name(run, LIMBER_CHANNELS, 0),
               values[0], limber_unit(run, LIMBER_CHANNELS, 0));
    }
    free(values);
  }
  if (status != LIMBER_OK) fprintf(stderr, "%s\n", limber_error(run));
  fputs(limber_warnings(run), stderr);
  limber_close(run);
  return status;
}
