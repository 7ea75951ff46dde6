!> The centres of wheels: gears, belts and racks turn wheels by each other and hold no centre. Where no other joint does, they move
!> apart, and the wheels go on turning as if they touched. Floor: analysis.
module limber_analysis_centres
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_analysis_outcome, only: outcome_type, warn
   use limber_model_scene, only: joint_gear, joint_rack, joint_belt
   use limber_output_joints, only: joint_displacement
   use limber_system_point_motion, only: point_position
   use limber_system_system, only: system_type
   implicit none
   private
   public :: check_centres

contains

   !> A warning, once for each joint, where its centres are at another distance than at the first sample by more than a hundredth of
   !> the radii: teeth are not so deep.
   subroutine check_centres(system, t, q, outcome)
      type(system_type), intent(in) :: system
      !> Time of a sample; coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      type(outcome_type), intent(inout) :: outcome
      real(wp), parameter :: part = 0.01_wp
      real(wp) :: distance
      integer :: i
      logical :: first
      first = .not. allocated(outcome%centres)
      if (first) allocate (outcome%centres(size(system%model%joints)), source=0.0_wp)
      do i = 1, size(system%model%joints)
         associate (joint => system%model%joints(i), known => outcome%centres(i))
            if (all(joint%kind /= [joint_gear, joint_rack, joint_belt])) cycle
            if (known < 0.0_wp) cycle
            distance = centre_distance(system, i, q)
            if (first) known = distance
            if (abs(distance - known) <= part*sum(abs(joint%radius))) cycle
            call warn(outcome, "nothing holds the centres of joint '"//joint%name//"': they are "//as_text(distance, 3)//' '// &
               & system%model%units%length//' apart at t = '//as_text(t, 4)//', and were '//as_text(known, 3)//' '// &
               & system%model%units%length//'; hold both by other joints, such as REVOLUTE')
            known = -1.0_wp
         end associate
      end do
   end subroutine check_centres

   !> Distance of two centres, or of the centre of a pinion from the line of its rack.
   pure real(wp) function centre_distance(system, joint, q) result(distance)
      type(system_type), intent(in) :: system
      !> Index of the joint
      integer, intent(in) :: joint
      real(wp), intent(in) :: q(:)
      real(wp) :: gap(2)
      associate (points => system%model%points, own => system%model%joints(joint))
         gap = point_position(system%model, system%layout, points(own%points(1)), q) - point_position(system%model, &
            & system%layout, points(own%points(2)), q)
         distance = norm2(gap)
         if (own%kind == joint_rack) distance = sqrt(max(0.0_wp, dot_product(gap, gap) - joint_displacement(system, joint, q)**2))
      end associate
   end function centre_distance

end module limber_analysis_centres
