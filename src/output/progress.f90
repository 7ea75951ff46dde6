!> Progress on a terminal. Floor: output; the one module of the library that writes to the terminal, because a bar is its whole
!> purpose. An analysis calls it at every step.
module limber_output_progress
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: error_unit
   use limber_base_kinds, only: wp, long
   implicit none
   private
   public :: progress_type, progress_line, teller_type

   !> Columns of the line
   integer, parameter :: line_width = 72

   !> A bar that is being drawn: start, update at every step, finish
   type :: progress_type
      !> Whether anything is drawn; set by `start`
      logical :: shown = .false.
      !> Least time between two drawings [s]
      real(wp) :: interval = 0.1_wp
      character(:), allocatable, private :: title
      real(wp), private :: t0 = 0.0_wp, t1 = 1.0_wp
      !> Clock at the start, at the last look and at the last drawing [ticks]
      integer(long), private :: started = 0, looked = 0, drawn = 0
      !> Calls until the next look at the clock, and between two looks
      integer, private :: countdown = 1, stride = 1
   contains
      procedure :: start, update, finish
   end type progress_type

   !> Lines of what a command is at that does many runs, once it takes long
   type :: teller_type
      !> Clock when it began; negative: it has not [ticks]
      integer(long), private :: began = -1
   contains
      procedure :: say
   end type teller_type

   !> Wall time until the first line [s]
   real(wp), parameter :: silent = 5.0_wp

   interface
      !> Whether a file descriptor is a terminal (POSIX)
      integer(c_int) function isatty(descriptor) bind(c, name='isatty')
         import :: c_int
         integer(c_int), value :: descriptor
      end function isatty
   end interface

contains

   !> Begins a bar; nothing is ever drawn unless standard error is a terminal.
   subroutine start(self, t0, t1, title)
      !> Bar
      class(progress_type), intent(inout) :: self
      !> First and last time of the run, in one unit
      real(wp), intent(in) :: t0, t1
      !> What is going on; at most 24 letters are shown
      character(*), intent(in) :: title
      integer(c_int), parameter :: standard_error = 2
      self%t0 = t0
      self%t1 = t1
      self%title = title(:min(len(title), 24))
      self%shown = isatty(standard_error) == 1
      self%stride = 1
      self%countdown = 1
      call system_clock(self%started)
      self%looked = self%started
      self%drawn = self%started
   end subroutine start

   !> Tells how far the run is. Cheap: looks at the clock only so often that it is looked at some 50 times a second.
   subroutine update(self, t)
      !> Bar
      class(progress_type), intent(inout) :: self
      !> Time reached
      real(wp), intent(in) :: t
      integer(long) :: clock, rate
      real(wp) :: since_look, fraction
      if (.not. self%shown) return
      self%countdown = self%countdown - 1
      if (self%countdown > 0) return
      call system_clock(clock, rate)
      since_look = real(clock - self%looked, wp)/real(rate, wp)
      if (since_look < 0.01_wp) self%stride = min(2*self%stride, 65536)
      if (since_look > 0.04_wp) self%stride = max(self%stride/2, 1)
      if (since_look > 0.5_wp) self%stride = 1
      self%countdown = self%stride
      self%looked = clock
      if (real(clock - self%drawn, wp) < self%interval*real(rate, wp)) return
      self%drawn = clock
      fraction = 1.0_wp
      if (abs(self%t1 - self%t0) > 0.0_wp) fraction = (t - self%t0)/(self%t1 - self%t0)
      write (error_unit, '(3a)', advance='no') achar(13), progress_line(self%title, fraction, &
         & real(clock - self%started, wp)/real(rate, wp), line_width), achar(13)
      flush (error_unit)
   end subroutine update

   !> A line on standard error, terminal or not: 'search for TARGET, 12 s: 7 runs; ...'. The first call begins the time.
   subroutine say(self, title, text)
      class(teller_type), intent(inout) :: self
      !> The command, and what it is at
      character(*), intent(in) :: title, text
      integer(long) :: clock, rate
      real(wp) :: wall
      call system_clock(clock, rate)
      if (self%began < 0) self%began = clock
      wall = real(clock - self%began, wp)/real(rate, wp)
      if (wall < silent) return
      write (error_unit, '(2a,i0,2a)') title, ', ', nint(wall), ' s: ', text
      flush (error_unit)
   end subroutine say

   !> Wipes the bar off the terminal.
   subroutine finish(self)
      !> Bar
      class(progress_type), intent(inout) :: self
      if (.not. self%shown) return
      write (error_unit, '(3a)', advance='no') achar(13), repeat(' ', line_width), achar(13)
      flush (error_unit)
      self%shown = .false.
   end subroutine finish

   !> One line: title, bar, per cent and the time left, estimated from the time gone.
   pure function progress_line(title, fraction, elapsed, width) result(line)
      !> What is going on
      character(*), intent(in) :: title
      !> Part that is done, 0 to 1; cut to that, and not a number counts as 0
      real(wp), intent(in) :: fraction
      !> Wall time gone [s]
      real(wp), intent(in) :: elapsed
      !> Length of the line; should exceed the title by 32
      integer, intent(in) :: width
      character(width) :: line
      character(4) :: per_cent
      character(:), allocatable :: left
      real(wp) :: done
      integer :: cells, full
      done = 0.0_wp
      if (.not. ieee_is_nan(fraction)) done = max(0.0_wp, min(fraction, 1.0_wp))
      write (per_cent, '(i3,a)') int(100.0_wp*done), '%'
      left = ''
      if (done > 1.0e-12_wp .and. elapsed > 0.0_wp) left = duration(elapsed*(1.0_wp - done)/done)//' left'
      cells = max(width - len(title) - len(per_cent) - 20, 1)
      full = int(done*cells)
      line = title//' ['//repeat('#', full)//repeat('.', cells - full)//'] '//per_cent//'  '//left
   end function progress_line

   !> A duration as 'm:ss' or 'h:mm:ss'; days as '99:59:59' at most.
   pure function duration(seconds) result(text)
      real(wp), intent(in) :: seconds
      character(:), allocatable :: text
      character(8) :: buffer
      integer :: whole
      whole = nint(min(seconds, 359999.0_wp))
      if (whole < 3600) then
         write (buffer, '(i2,":",i2.2)') whole/60, mod(whole, 60)
      else
         write (buffer, '(i2,2(":",i2.2))') whole/3600, mod(whole/60, 60), mod(whole, 60)
      end if
      text = trim(adjustl(buffer))
   end function duration

end module limber_output_progress
