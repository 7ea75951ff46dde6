!> Warnings of the start. What the assembly has changed of what the deck gives, redundant joints, springs without a direction.
!> Floor: scene.
module limber_scene_start_warnings
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_scene_given_state, only: change_type, changed_places, changed_velocities
   use limber_scene_scene, only: scene_type, place_of, place_of_body, starts_with_dynamics
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_model_beam_segments, only: name_in_deck
   use limber_model_model, only: along_distance, ground, place_at_point
   use limber_monitor_body_surveys, only: is_base
   use limber_multibody_point_motion, only: point_position
   use limber_multibody_redundant_constraints, only: group_names, constraint_names
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: warn_of_redundancy, warn_of_turn, warn_of_springs, warn_of_changes, warn_of_supports

contains

   !> Warns of beams whose SUPPORT holds more than a floating frame needs, where no joint holds them: they cannot bend or stretch
   !> there.
   subroutine warn_of_supports(scene, diagnostics)
      type(scene_type), intent(in) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Conditions that define a floating frame
      integer, parameter :: enough = 3
      !> By the support, and by joints: displacement along and across, and rotation, of the start and of the end
      logical :: held(3, 2), joined(3, 2)
      integer :: i
      do i = 1, size(scene%system%model%bodies)
         associate (body => scene%system%model%bodies(i))
            if (scene%system%layout%n(i) == 0 .or. body%is_frame .or. body%reduced%is_exact) cycle
            associate (support => body%choice%support)
               held = reshape([support%u_start, support%w_start, support%theta_start, support%u_end, support%w_end, &
                  & support%theta_end], [3, 2])
            end associate
            if (count(held) <= enough) cycle
            call find_joined(scene%system, i, joined)
            if (any(held .and. .not. joined)) call warn_of_support(scene, i, held_text(held .and. .not. joined), diagnostics)
         end associate
      end do
   end subroutine warn_of_supports

   !> Warns of one of them.
   subroutine warn_of_support(scene, body, what, diagnostics)
      type(scene_type), intent(in) :: scene
      !> Its index
      integer, intent(in) :: body
      !> What no joint holds
      character(*), intent(in) :: what
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: block
      block = scene%deck%find_named('BEAM', name_in_deck(scene%system%model, body))
      if (block == 0) return
      associate (beam => scene%deck%blocks(block))
         call diagnostics%warn(beam%origin_of('SUPPORT'), 'SUPPORT='//beam%word('SUPPORT')//' holds '//what//" of beam '"// &
            & beam%name()//"' in its frame, and no joint does: it cannot move there as it would", &
            & 'use SUPPORT=PINNED-ROLLER or CLAMPED-FREE with CORRECTIONS=YES, or GEOMETRIC=EXACT')
      end associate
   end subroutine warn_of_support

   !> What joints with the ground, or with rigid bodies of known motion, hold of the ends of a beam; all if anything acts on its
   !> frame.
   pure subroutine find_joined(system, body, joined)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      !> Displacement along and across, rotation, of the start and of the end
      logical, intent(out) :: joined(:, :)
      !> Distance of a point from an end, in parts of the length
      real(wp), parameter :: near = 1.0e-6_wp
      real(wp) :: x
      integer :: i, side, at
      joined = .false.
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               if (item%bodies(side) /= body) cycle
               if (item%points(side) == 0) then
                  joined = .true.
                  return
               end if
               ! What moves freely, or does not act, holds nothing
               if (item%rows == 0 .or. .not. is_base(system, item%bodies(3 - side))) cycle
               if (i > size(system%model%joints)) cycle
               associate (own => system%model%bodies(body), joint => system%model%joints(i))
                  x = (system%model%points(item%points(side))%p0(1) + own%choice%origin)/own%beam%length
                  at = 0
                  if (abs(x) < near) at = 1
                  if (abs(x - 1) < near) at = 2
                  if (at == 0) cycle
                  joined(1, at) = joined(1, at) .or. joint%place == place_at_point
                  joined(2, at) = .true.
                  joined(3, at) = joined(3, at) .or. joint%keeps_angle
               end associate
            end do
         end associate
      end do
   end subroutine find_joined

   !> Names of what is held.
   pure function held_text(held) result(text)
      !> Displacement along and across, rotation, of the start and of the end
      logical, intent(in) :: held(3, 2)
      character(:), allocatable :: text
      character(*), parameter :: what(3) = [character(27) :: 'the axial displacement', 'the deflection', 'the rotation'], &
         & where(2) = [character(5) :: 'start', 'end']
      integer :: i, k
      text = ''
      do k = 1, 2
         do i = 1, 3
            if (.not. held(i, k)) cycle
            if (text /= '') text = text//' and '
            text = text//trim(what(i))//' at the '//trim(where(k))
         end do
      end do
   end function held_text

   !> Names the constraints that share redundant equations, group by group, and those that do so at the first position only.
   subroutine warn_of_redundancy(scene, diagnostics)
      type(scene_type), intent(in) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, parameter :: most = 5
      integer :: k, groups
      associate (system => scene%system, redundancy => scene%assembly%redundancy, singular => scene%assembly%singular)
         groups = 0
         if (redundancy%count > 0) groups = size(redundancy%excess)
         do k = 1, min(groups, most)
            call diagnostics%warn(place_of(scene, redundancy%last(k)), equations_are(redundancy%excess(k))//' redundant among '// &
               & group_names(system, redundancy, k)//'; the motion is not changed by that, and of the reactions that balance'// &
               & ' those of least norm are reported'//shared_text(system, redundancy%group == k))
         end do
         if (groups > most) call diagnostics%warn(place_of(scene, redundancy%last(most + 1)), as_text(groups - most)// &
            & ' more groups of joints have redundant equations, '//as_text(redundancy%count)//' in all')
         if (singular%count > 0) call diagnostics%warn(place_of(scene, maxval(singular%last)), 'the mechanism starts at a'// &
            & ' singular position, where '//constraint_names(system, singular%group > 0)//' let branches of its motion meet: it'// &
            & ' goes on along the one that the guessed velocities are nearest to')
      end associate
   end subroutine warn_of_redundancy

   !> What is to be said where elasticity would tell how constraints share their reactions: the first beam or frame among their
   !> bodies, of which the functions do not move what they hold. Else nothing.
   pure function shared_text(system, chosen) result(text)
      type(system_type), intent(in) :: system
      !> Which (constraints)
      logical, intent(in) :: chosen(:)
      character(:), allocatable :: text
      integer :: i, side, body
      text = ''
      do i = 1, size(chosen)
         if (.not. chosen(i)) cycle
         do side = 1, 2
            body = system%constraints(i)%item%bodies(side)
            if (body == ground) cycle
            if (system%layout%n(body) == 0) cycle
            text = name_in_deck(system%model, body)
            text = ", not those that elasticity makes: the functions of '"//text//"' do not move what these joints hold; use"// &
               & ' SUPPORT=PINNED-ROLLER (of a frame: *BOUNDARY of one node) with CORRECTIONS=YES'
            return
         end do
      end do
   end function shared_text

   !> Says that the first position is far from the guess, for then its branch is a matter of luck.
   subroutine warn_of_turn(scene, diagnostics)
      type(scene_type), intent(in) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: origin
      integer :: block
      associate (model => scene%system%model, found => scene%assembly)
         if (found%turned <= model%assembly%largest_turn) return
         origin = origin_type(file=1)
         block = scene%deck%find_named('RIGID BODY|BEAM|FRAME', name_in_deck(model, found%body))
         if (block > 0) origin = scene%deck%blocks(block)%origin_of('NAME')
         call diagnostics%warn(origin, "the assembly has turned body '"//model%bodies(found%body)%name//"' by "// &
            & as_text(found%turned, 3)//' rad from its guess: make sure that the branch is the one that is meant, or give ANGLE=')
      end associate
   end subroutine warn_of_turn

   !> Springs, linear or with a law, that pull or push between points that coincide: their force has no direction.
   subroutine warn_of_springs(scene, diagnostics)
      type(scene_type), intent(in) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: origin
      real(wp) :: gap(2)
      integer :: i, k, block
      associate (model => scene%system%model, layout => scene%system%layout)
         do i = 1, size(model%loads)
            do k = model%loads(i)%first, model%loads(i)%last
               associate (spring => model%load_parts(k))
                  if (spring%along /= along_distance .or. .not. (spring%driven .or. spring%stiffness > 0.0_wp)) cycle
                  gap = point_position(model, layout, model%points(spring%points(1)), scene%q) &
                     & - point_position(model, layout, model%points(spring%points(2)), scene%q)
                  if (norm2(gap) > 1.0e-12_wp*spring%origin .or. .not. spring%origin > 0.0_wp) cycle
               end associate
               origin = origin_type(file=1)
               block = scene%deck%find_named('SPRING', model%loads(i)%name)
               if (block > 0) origin = scene%deck%blocks(block)%origin_of('NAME')
               call diagnostics%warn(origin, "the points of spring '"//model%loads(i)%name//"' are in one place at first: its"// &
                  & ' force has no direction there and is taken for zero', 'move one of them a little in the direction that is'// &
                  & ' meant, or give LENGTH=0')
            end do
         end do
      end associate
   end subroutine warn_of_springs

   !> Says which bodies do not start as the deck gives them, at the one that has changed most: places if the motion depends on them,
   !> and velocities.
   subroutine warn_of_changes(scene, diagnostics)
      type(scene_type), intent(in) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(change_type), allocatable :: changes(:)
      logical :: matters
      matters = scene%assembly%rank < sum(scene%system%layout%rates) .and. starts_with_dynamics(scene%system%model)
      call changed_places(scene%system, scene%q, changes)
      ! Of one that has turned far there has been a warning
      if (scene%assembly%turned > scene%system%model%assembly%largest_turn .and. size(changes) > 0) then
         if (changes(1)%body == scene%assembly%body) matters = .false.
      end if
      if (matters .and. size(changes) > 0) call diagnostics%warn(place_of_body(scene, changes(1)%body), "body '"// &
         & name_in_deck(scene%system%model, changes(1)%body)// &
         & "' does not start where it is given, which its joints do not allow together with what is given of the"// &
         & ' other bodies: '//changes(1)%text//others(scene, changes), &
         & 'give X=, Y= and ANGLE= that its joints allow, or of fewer bodies')
      call changed_velocities(scene%system, scene%q, scene%v, changes)
      if (size(changes) > 0) call diagnostics%warn(place_of_body(scene, changes(1)%body), "body '"// &
         & name_in_deck(scene%system%model, changes(1)%body)// &
         & "' does not start with the velocity that it is given, which its joints do not allow together with those of the"// &
         & ' other bodies: it is off by '//as_text(100*changes(1)%off, 2)//' % ('//changes(1)%text//')'//others(scene, changes), &
         & 'give VX=, VY= and SPIN= as the joints let them move, or of fewer bodies')
   end subroutine warn_of_changes

   !> What has changed of the bodies behind the first.
   function others(scene, changes) result(text)
      type(scene_type), intent(in) :: scene
      type(change_type), intent(in) :: changes(:)
      character(:), allocatable :: text
      !> As many as are named
      integer, parameter :: most = 8
      integer :: i
      text = ''
      do i = 2, min(most, size(changes))
         text = text//trim(merge('; nor does', ',         ', i == 2))//" body '"// &
            & name_in_deck(scene%system%model, changes(i)%body)//"' ("//changes(i)%text//')'
      end do
      if (size(changes) > most) text = text//' and '//as_text(size(changes) - most)//' more'
   end function others

   pure function equations_are(count) result(text)
      integer, intent(in) :: count
      character(:), allocatable :: text
      text = as_text(count)//' equations are'
      if (count == 1) text = '1 equation is'
   end function equations_are

end module limber_scene_start_warnings
