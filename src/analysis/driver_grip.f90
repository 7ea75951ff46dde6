!> The grip of drivers and joints on a driven motion. What the constraints answer to a fixed load: it grows without bound towards a
!> position in which they hold some motion no longer, and is the opposite behind it. Steps in which it changes by a part of itself
!> come to such a position and jump over none. Floor: analysis. Source: doc/theory, section 6.8.
!>
!>     call start_grip(self, system, held)            ! once
!>     call begin_grip(self, system, work, held, t, q) ! where a way begins
!>     h = min(h, grip_time(self))                    ! before a step
!>     call feel_grip(self, system, held, keeps)      ! behind `held_position`: whether the step was short enough
!>     call keep_grip(self, h)                        ! when it is taken
module limber_analysis_driver_grip
   use limber_base_kinds, only: wp
   use limber_multibody_driven_motion, only: driven_motion_type, factor_held
   use limber_multibody_redundant_constraints, only: constraint_names
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: solve_refined
   implicit none
   private
   public :: grip_type, start_grip, begin_grip, grip_time, feel_grip, keep_grip, drivers_text

   !> Part of itself by which the answer may change in a step
   real(wp), parameter :: most = 0.5_wp
   !> Answer, in units of the smallest seen, beyond which the grip is lost: positions are known to 1e-7 there
   real(wp), parameter :: none = 1.0e6_wp

   !> What is remembered
   type :: grip_type
      !> The load (nw); units of the multipliers (nc)
      real(wp), allocatable :: load(:), unit(:)
      !> Answers, work on the scale of each equation, at the last place and at the one tried (nc)
      real(wp), allocatable :: last(:), now(:)
      !> Part of itself by which it has changed last [1/time]; below zero: unknown
      real(wp) :: rate = -1.0_wp
      !> The smallest seen
      real(wp) :: least = huge(1.0_wp)
   end type grip_type

contains

   !> Room, and the load: on each frame coordinate another one, of the order of one by the scale of the coordinate.
   subroutine start_grip(self, system, held)
      type(grip_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(in) :: held
      real(wp), parameter :: spread = 2.4_wp
      integer :: i
      allocate (self%load(system%layout%nw), self%unit(system%nc), self%last(system%nc), self%now(system%nc))
      self%load = [((1.0_wp + 0.5_wp*sin(spread*i))/held%scale(i), i=1, size(self%load))]
      self%load(held%deflections) = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            self%unit(item%first:item%first + item%rows - 1) = item%scale
         end associate
      end do
      self%last = 0.0_wp
      self%now = 0.0_wp
   end subroutine start_grip

   !> Takes the place where a way begins; behind it rates and accelerations of `held` are as before.
   subroutine begin_grip(self, system, work, held, t, q)
      type(grip_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      !> Time; coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      real(wp) :: a(size(held%a)), lambda(size(held%lambda))
      logical :: singular
      a = held%a
      lambda = held%lambda
      held%moved = 0.0_wp
      call factor_held(system, work, held, t, q, held%moved, singular)
      if (.not. singular) call answer(self, system, held)
      self%last = self%now
      self%least = min(self%least, maxval(abs(self%last)))
      held%a = a
      held%lambda = lambda
   end subroutine begin_grip

   !> The answer at the place where `held` is factored.
   subroutine answer(self, system, held)
      type(grip_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(inout) :: held
      associate (nw => system%layout%nw)
         held%solution(:nw) = self%load
         held%solution(nw + 1:) = 0.0_wp
         call solve_refined(held%tangent, nw, held%solution, held%correction)
         self%now = held%solution(nw + 1:)*self%unit
      end associate
   end subroutine answer

   !> Longest step in which the answer, as it has changed last, changes by the part of itself that is allowed.
   pure real(wp) function grip_time(self) result(h)
      type(grip_type), intent(in) :: self
      h = huge(h)
      if (self%rate > most/h) h = most/self%rate
   end function grip_time

   !> Whether the answer at the place that was found last agrees with that before.
   subroutine feel_grip(self, system, held, keeps)
      type(grip_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Factored there
      type(driven_motion_type), intent(inout) :: held
      logical, intent(out) :: keeps
      real(wp) :: size_of
      call answer(self, system, held)
      size_of = maxval(abs(self%now))
      keeps = maxval(abs(self%now - self%last)) <= most*min(size_of, maxval(abs(self%last))) .and. size_of <= none*self%least
   end subroutine feel_grip

   !> The step is taken.
   pure subroutine keep_grip(self, h)
      type(grip_type), intent(inout) :: self
      !> Its length
      real(wp), intent(in) :: h
      self%rate = maxval(abs(self%now - self%last))/max(tiny(h), h*maxval(abs(self%now)))
      self%last = self%now
      self%least = min(self%least, maxval(abs(self%last)))
   end subroutine keep_grip

   !> The drivers that take part where the grip is lost: the multipliers there are those of the equations that contradict each
   !> other.
   function drivers_text(self, system) result(text)
      type(grip_type), intent(in) :: self
      type(system_type), intent(in) :: system
      character(:), allocatable :: text
      real(wp), parameter :: takes_part = 0.1_wp
      real(wp) :: part(size(system%constraints))
      logical :: drives(size(system%constraints))
      integer :: i
      part = 0.0_wp
      associate (joints => size(system%model%joints), drivers => size(system%model%drivers))
         do i = joints + 1, joints + drivers
            associate (item => system%constraints(i)%item)
               part(i) = maxval(abs(self%last(item%first:item%first + item%rows - 1)))
            end associate
         end do
         drives = part > takes_part*maxval(part)
         text = ''
         if (any(drives)) text = constraint_names(system, drives)//': '
      end associate
   end function drivers_text

end module limber_analysis_driver_grip
