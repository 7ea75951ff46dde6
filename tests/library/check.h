/* Counts what is not as it should be */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int faults = 0;

static void check(int right, const char *what)
{
  if (right) return;
  faults++;
  printf("wrong: %s\n", what);
}
