/* Processes that end by _exit, the workers of sweeps, would lose their counts of lines: in builds for coverage they write them. */
#include <sys/syscall.h>
#include <unistd.h>

extern void __gcov_dump(void);

void _exit(int status)
{
    __gcov_dump();
    syscall(SYS_exit_group, status);
    for (;;) { }
}
