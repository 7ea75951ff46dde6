!> Vibrations on springs and bushings that CONSERVING does not follow. It keeps their energy, so that the springs of a state at the
!> end
!> of a step are off by as much as ever, while the mean of each step is right. Floor: analysis. Source: doc/theory, section 5.10.
module limber_analysis_ringing_springs
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_integrator_unfollowed_vibrations, only: ringing_type
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: ringing_springs_type

   !> Part of the largest acceleration of a body by which one at a sample may be off
   real(wp), parameter :: allowed = 0.02_wp
   !> Part of the largest acceleration of all points below which that of a body is round-off
   real(wp), parameter :: none = 1.0e-6_wp

   type :: ringing_springs_type
      !> Largest acceleration of each body at samples, and by how much one was off (bodies)
      real(wp), allocatable, private :: top(:), off(:)
      !> Largest acceleration of a point of any body
      real(wp), private :: greatest = 0.0_wp
   contains
      procedure :: start, look, warning, exchange => exchange_springs
   end type ringing_springs_type

contains

   !> Begins; not called where nothing is watched.
   subroutine start(self, system)
      class(ringing_springs_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      allocate (self%top(size(system%layout%q)), self%off(size(system%layout%q)), source=0.0_wp)
   end subroutine start

   !> Compares the accelerations at the end of a step with its mean. A motion that is followed changes by as much from step to step.
   pure subroutine look(self, system, ringing, a)
      class(ringing_springs_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> With the means of the last two steps
      type(ringing_type), intent(in) :: ringing
      !> Accelerations of a sample at the end of the last (nq)
      real(wp), intent(in) :: a(:)
      integer :: i
      if (.not. allocated(self%top) .or. ringing%known < 2) return
      do i = 1, size(self%top)
         associate (q => system%layout%q(i), w => system%layout%w(i))
            self%greatest = max(self%greatest, norm2(a(q:q + 1)))
            if (system%layout%framed(i)) self%greatest = max(self%greatest, system%model%bodies(i)%size*norm2(a(q + 2:q + 3)))
            self%top(i) = max(self%top(i), norm2(a(q:q + 1)), norm2(ringing%last(w:w + 1)))
            self%off(i) = max(self%off(i), norm2(a(q:q + 1) - ringing%last(w:w + 1)) - 2*norm2(ringing%last(w:w + 1) - &
               & ringing%before(w:w + 1)))
         end associate
      end do
   end subroutine look

   !> A warning if accelerations were off; empty if none was.
   function warning(self, system) result(text)
      class(ringing_springs_type), intent(in) :: self
      type(system_type), intent(in) :: system
      character(:), allocatable :: text
      real(wp) :: least
      integer :: worst
      text = ''
      if (.not. allocated(self%top)) return
      ! Accelerations that are round-off, or move nothing in the whole run
      associate (dynamics => system%model%dynamics)
         least = none*max(self%greatest, system%model%length/(dynamics%end - dynamics%start)**2)
      end associate
      worst = maxloc(merge(self%off - allowed*self%top, -1.0_wp, self%off > least), dim=1)
      if (self%off(worst) <= least) return
      if (self%off(worst) <= allowed*self%top(worst)) return
      text = "CONSERVING does not follow a vibration of body '"//system%model%bodies(worst)%name//"' on its springs, joints or"// &
         & ' neighbours, and keeps it up: accelerations and forces asked for may err by about '//as_text(100*min(1.0_wp, &
         & self%off(worst)/self%top(worst)), 2)//' % of the largest acceleration of that body; use INTEGRATOR=RADAU, or ask for'// &
         & ' places and speeds'
   end function warning

   !> Saves or restores its memory.
   subroutine exchange_springs(self, snapshot)
      class(ringing_springs_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('spring_top', self%top)
      call snapshot%keep('spring_off', self%off)
      call snapshot%exchange('spring_greatest', self%greatest)
   end subroutine exchange_springs

end module limber_analysis_ringing_springs
