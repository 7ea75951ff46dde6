!> Checks of gears, belts and racks. Gears, belts and racks turn wheels by each other and hold no centre: where no other joint does,
!> the wheels move apart, and go on turning as if they touched. A point that slides along a beam, or on an open curve through
!> points, goes on along a straight line behind its end. Floor: scene.
module limber_scene_joint_check
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_scene_outcome, only: outcome_type, warn
   use limber_output_joint_forces, only: joint_displacement
   use limber_model_model, only: function_displacement, place_on_curve, place_on_beam, place_rolling
   use limber_multibody_plane_vectors, only: along, cross
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_path_constraints, only: curve_joint_type
   use limber_multibody_point_motion, only: point_position
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: check_joints, watches_joints

contains

   !> Whether there is a joint that takes anything for granted.
   pure logical function watches_joints(system)
      type(system_type), intent(in) :: system
      integer :: i
      watches_joints = .false.
      do i = 1, size(system%model%joints)
         watches_joints = watches_joints .or. any(system%model%joints(i)%place == [place_rolling, place_on_beam, &
            & place_on_curve])
      end do
   end function watches_joints

   !> A warning, once for each joint, where what it takes for granted is not so.
   subroutine check_joints(system, work, t, q, outcome)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time of a sample; coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      type(outcome_type), intent(inout) :: outcome
      integer :: i
      logical :: first
      first = .not. allocated(outcome%centres)
      if (first) allocate (outcome%centres(size(system%model%joints)), source=0.0_wp)
      do i = 1, size(system%model%joints)
         if (outcome%centres(i) < 0.0_wp) cycle
         select case (system%model%joints(i)%place)
         case (place_rolling)
            call check_centres(system, i, t, q, first, outcome)
         case (place_on_beam)
            call check_ends(system, i, t, q, outcome)
         case (place_on_curve)
            call check_curve(system, work, i, t, q, outcome)
         end select
      end do
   end subroutine check_joints

   !> Centres at another distance than at the first sample by more than a hundredth of the radii: teeth are not so deep.
   subroutine check_centres(system, joint, t, q, first, outcome)
      type(system_type), intent(in) :: system
      integer, intent(in) :: joint
      real(wp), intent(in) :: t, q(:)
      !> Whether this is the first sample
      logical, intent(in) :: first
      type(outcome_type), intent(inout) :: outcome
      real(wp), parameter :: part = 0.01_wp
      real(wp) :: distance
      associate (own => system%model%joints(joint), known => outcome%centres(joint))
         distance = centre_distance(system, joint, q)
         if (first) known = distance
         if (abs(distance - known) <= part*sum(abs(own%radius))) return
         call warn(outcome, "nothing holds the centres of joint '"//own%name//"': they are "//as_text(distance, 3)//' '// &
            & system%model%units%length//' apart at t = '//as_text(t, 4)//', and were '//as_text(known, 3)//' '// &
            & system%model%units%length//'; hold both by other joints, such as REVOLUTE')
         known = -1.0_wp
      end associate
   end subroutine check_centres

   !> A point that slides along a beam, behind one of its ends: on the tangent there.
   subroutine check_ends(system, joint, t, q, outcome)
      type(system_type), intent(in) :: system
      integer, intent(in) :: joint
      real(wp), intent(in) :: t, q(:)
      type(outcome_type), intent(inout) :: outcome
      !> Part of the length of the beam that does not matter
      real(wp), parameter :: part = 1.0e-3_wp
      real(wp) :: gap(2), axis(2), length, past
      integer :: i, beam, first
      logical :: is_start
      associate (points => system%model%points, own => system%model%joints(joint))
         beam = points(own%points(2))%body
         length = system%model%bodies(beam)%beam%length
         first = system%layout%q(beam) + 4
         do i = 1, size(points)
            if (points(i)%body /= beam .or. points(i)%direction) cycle
            is_start = points(i)%name == system%model%bodies(beam)%name//'.start'
            if (.not. is_start .and. points(i)%name /= system%model%bodies(beam)%name//'.end') cycle
            gap = point_position(system%model, system%layout, points(own%points(1)), q) &
               & - point_position(system%model, system%layout, points(i), q)
            axis(2) = dot_product(points(i)%psi, q(first:first + size(points(i)%psi) - 1))
            axis = along([cos(axis(2)), sin(axis(2))], q(first - 2:first - 1))
            past = dot_product(gap, axis)
            if (is_start) past = -past
            if (past <= part*length .or. abs(cross(axis, gap)) > part*length) cycle
            call warn(outcome, "joint '"//own%name//"' slides past the end of beam '"//system%model%bodies(beam)%name// &
               & "' before t = "//as_text(t, 4)//', by '//as_text(past, 3)//' '//system%model%units%length//' there: behind its'// &
               & ' end the beam goes on as a straight line without mass; END the analysis before, or give the beam another LENGTH')
            outcome%centres(joint) = -1.0_wp
            return
         end do
      end associate
   end subroutine check_ends

   !> A point on an open curve, behind one of its ends: on the tangent there.
   subroutine check_curve(system, work, joint, t, q, outcome)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: joint
      real(wp), intent(in) :: t, q(:)
      type(outcome_type), intent(inout) :: outcome
      !> Part of the length of the curve that does not matter
      real(wp), parameter :: part = 1.0e-3_wp
      real(wp) :: place(2), past
      select type (item => system%constraints(joint)%item)
      type is (curve_joint_type)
         if (item%curve%explicit) return
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         call item%place(work%kinematics, place)
         past = item%curve%past(place)
         if (past <= part*maxval(item%curve%s)) return
         call warn(outcome, "joint '"//system%model%joints(joint)%name//"': its point leaves the end of its curve before t = "// &
            & as_text(t, 4)//', by '//as_text(past, 3)//' '//system%model%units%length//' there: behind its ends an open curve'// &
            & ' goes on straight; END the analysis before, or give the curve more points')
         outcome%centres(joint) = -1.0_wp
      end select
   end subroutine check_curve

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
         if (any(own%functions%function == function_displacement)) distance = sqrt(max(0.0_wp, dot_product(gap, gap) &
            & - joint_displacement(system, joint, q)**2))
      end associate
   end function centre_distance

end module limber_scene_joint_check
