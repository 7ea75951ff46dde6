!> Curves of several formulas without dynamics. A jump between two of them is an error, and a kink is told where velocities count.
!> Floor: analysis. Source: doc/theory, eq. (5.58).
module limber_analysis_curve_path
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_scene_outcome, only: outcome_type, warn
   use limber_model_curve_breaks, only: curve_break_type, find_curve_breaks, break_jump, break_kink
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_path_constraints, only: curve_joint_type
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: curve_path_type, new_paths, follow_paths, break_text

   !> What is remembered
   type :: curve_path_type
      !> Constraints, and the last place x of the point of each
      integer, allocatable :: joints(:)
      real(wp), allocatable :: x(:)
      !> Whether a kink of it has been told
      logical, allocatable :: told(:)
   end type curve_path_type

contains

   !> Which curves these are, and where their points are.
   subroutine new_paths(self, system, kinematics)
      type(curve_path_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> Placed
      type(kinematics_type), intent(in) :: kinematics
      logical :: watched(size(system%constraints))
      integer :: i
      watched = .false.
      do i = 1, size(watched)
         select type (item => system%constraints(i)%item)
         type is (curve_joint_type)
            if (item%part_of == 0 .and. item%curve%explicit) watched(i) = item%curve%expression%may_bend()
         end select
      end do
      self%joints = pack([(i, i=1, size(watched))], watched)
      allocate (self%x(size(self%joints)), source=0.0_wp)
      allocate (self%told(size(self%joints)), source=.false.)
      do i = 1, size(self%joints)
         self%x(i) = place_of(system, kinematics, self%joints(i))
      end do
   end subroutine new_paths

   !> Goes on to the next place.
   subroutine follow_paths(self, system, kinematics, t, moves, outcome, error)
      type(curve_path_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: t
      !> Whether velocities and accelerations are those of a motion
      logical, intent(in) :: moves
      type(outcome_type), intent(inout) :: outcome
      !> A curve jumps
      type(error_type), allocatable, intent(out) :: error
      !> Part of the length of the scene that is looked at beyond both places
      real(wp), parameter :: aside = 1.0e-9_wp
      type(curve_break_type), allocatable :: breaks(:)
      real(wp) :: before
      integer :: i, j
      do i = 1, size(self%joints)
         before = self%x(i)
         self%x(i) = place_of(system, kinematics, self%joints(i))
         if (.not. abs(self%x(i) - before) > 0.0_wp) cycle
         select type (item => system%constraints(self%joints(i))%item)
         type is (curve_joint_type)
            call find_curve_breaks(item%curve, min(before, self%x(i)) - aside*system%model%length, &
               & max(before, self%x(i)) + aside*system%model%length, breaks)
            do j = 1, size(breaks)
               if (breaks(j)%kind == break_jump) then
                  call raise(error, item%label//': its curve jumps at x = '//as_text(breaks(j)%place, 6)//', from y = '// &
                     & as_text(breaks(j)%left%value, 6)//' to '//as_text(breaks(j)%right%value, 6)//', which its point passes'// &
                     & ' before t = '//as_text(t, 8)//'; a point cannot follow: use smoothstep((x - x0)/width) in place of a jump')
                  return
               end if
               if (breaks(j)%kind /= break_kink .or. self%told(i) .or. .not. moves) cycle
               self%told(i) = .true.
               call warn(outcome, item%label//': its point passes a kink of its curve, at x = '//as_text(breaks(j)%place, 6)// &
                  & ', before t = '//as_text(t, 6)//': velocities jump there, which takes an impact that accelerations,'// &
                  & ' reactions and torques lack; round it by a *CURVE through points or smoothstep')
            end do
         end select
      end do
   end subroutine follow_paths

   !> A hint at the jump or kink of a curve that is nearest to the place of its point, where none is found behind it; empty if there
   !> is none in reach.
   function break_text(self, system) result(text)
      type(curve_path_type), intent(in) :: self
      type(system_type), intent(in) :: system
      character(:), allocatable :: text
      type(curve_break_type), allocatable :: breaks(:)
      real(wp) :: nearest
      integer :: i, j
      text = ''
      nearest = system%model%length
      do i = 1, size(self%joints)
         select type (item => system%constraints(self%joints(i))%item)
         type is (curve_joint_type)
            call find_curve_breaks(item%curve, self%x(i) - nearest, self%x(i) + nearest, breaks)
            do j = 1, size(breaks)
               if (abs(breaks(j)%place - self%x(i)) > nearest) cycle
               if (breaks(j)%kind /= break_jump .and. breaks(j)%kind /= break_kink) cycle
               nearest = abs(breaks(j)%place - self%x(i))
               text = '; the curve of '//item%label//' '//trim(merge('jumps     ', 'has a kink', breaks(j)%kind == break_jump))// &
                  & ' at x = '//as_text(breaks(j)%place, 6)//': use smoothstep((x - x0)/width), or a *CURVE through points'
            end do
         end select
      end do
   end function break_text

   !> Where the point of a curve is.
   real(wp) function place_of(system, kinematics, joint) result(x)
      type(system_type), intent(in) :: system
      type(kinematics_type), intent(in) :: kinematics
      !> Index of the constraint
      integer, intent(in) :: joint
      real(wp) :: place(2)
      place = 0.0_wp
      select type (item => system%constraints(joint)%item)
      type is (curve_joint_type)
         call item%place(kinematics, place)
      end select
      x = place(1)
   end function place_of

end module limber_analysis_curve_path
