!> A scene. What is made of a deck: the system, its first state, and what the last analysis has left. Floor: scene.
module limber_scene_scene
   use limber_base_kinds, only: wp, long
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type
   use limber_deck_origin, only: origin_type
   use limber_model_beam_segments, only: name_in_deck
   use limber_model_model, only: model_type, step_dynamics
   use limber_multibody_constraint_rank, only: assembly_type
   use limber_multibody_kinematics, only: angle_type
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: scene_type, place_of, place_of_body, starts_with_dynamics, mobility_line, inner_joints, seconds_since

   !> What an analysis leaves to the next
   type :: carried_type
      !> Coordinates and velocities at its end (nq); accumulated angles of the bodies' frames (bodies) [rad]
      real(wp), allocatable :: q(:), v(:), angle(:)
      !> True if it ended in equilibrium, with these multipliers (nc), in a steady rotation about a centre [rad/time], [length]
      logical :: balanced = .false.
      real(wp), allocatable :: lambda(:)
      real(wp) :: rotation = 0.0_wp, centre(2) = 0.0_wp
   contains
      procedure :: exchange => exchange_carried
   end type carried_type

   !> A scene ready to be analysed
   type :: scene_type
      type(deck_type) :: deck
      type(system_type) :: system
      type(workspace_type) :: work
      !> Assembled coordinates and velocities at the first time (nq)
      real(wp), allocatable :: q(:), v(:)
      !> That time: the start of the analysis, or right behind it where a driver changes its speed there; less: not known
      real(wp) :: begin = -huge(1.0_wp)
      !> Rank of the constraints, what is redundant, and the way from the guess
      type(assembly_type) :: assembly
      !> What the last analysis has left; and the accumulated angles that the present one starts from, if it is not the first
      type(carried_type) :: last
      real(wp), allocatable :: angle(:)
      !> Angles that laws, joints and loads follow, as the last motion has begun with them: one that is run again begins so too
      type(angle_type), allocatable :: followed(:)
      !> Rendered warnings, one after another; empty if there are none
      character(:), allocatable :: warnings
      !> Wall seconds for reading the deck, for building model and modes, and for the assembly
      real(wp) :: reading = 0.0_wp, building = 0.0_wp, assembling = 0.0_wp
   end type scene_type

contains

   !> Whether the first analysis is a dynamic one.
   pure logical function starts_with_dynamics(model)
      type(model_type), intent(in) :: model
      starts_with_dynamics = .false.
      if (.not. allocated(model%steps)) return
      if (size(model%steps) > 0) starts_with_dynamics = model%steps(1)%kind == step_dynamics
   end function starts_with_dynamics

   !> Where a joint or driver stands in the deck.
   pure function place_of(scene, constraint) result(origin)
      class(scene_type), intent(in) :: scene
      !> Its index among the constraints
      integer, intent(in) :: constraint
      type(origin_type) :: origin
      integer :: block, beam, number
      beam = 0
      ! A coupler of many bodies has several
      number = constraint
      if (scene%system%constraints(constraint)%item%part_of > 0) number = scene%system%constraints(constraint)%item%part_of
      associate (model => scene%system%model)
         if (number <= size(model%joints)) then
            block = scene%deck%find_named('JOINT|COUPLER', model%joints(number)%name)
            ! One between the segments of a beam
            if (block == 0) beam = scene%deck%find_named('BEAM|FRAME', name_in_deck(model, &
               & model%points(model%joints(number)%points(1))%body))
         else if (number > size(model%joints) + size(model%drivers)) then
            block = model%contacts(number + size(model%contacts) - size(scene%system%constraints))%block
         else
            associate (name => model%drivers(number - size(model%joints))%name)
               block = scene%deck%find_named('DRIVER', name)
               ! One of the three of a motion: NAME_x, NAME_y, NAME_angle
               if (block == 0) block = scene%deck%find_named('MOTION', name(:index(name, '_', back=.true.) - 1))
            end associate
         end if
      end associate
      origin = origin_type(file=1)
      if (block > 0) origin = scene%deck%blocks(block)%origin_of('NAME')
      if (beam > 0) origin = scene%deck%blocks(beam)%origin_of('SEGMENTS')
   end function place_of

   !> Where a body stands in the deck.
   pure function place_of_body(scene, body) result(origin)
      type(scene_type), intent(in) :: scene
      !> Its index
      integer, intent(in) :: body
      type(origin_type) :: origin
      integer :: block
      origin = origin_type(file=1)
      block = scene%deck%find_named('RIGID BODY|POINT MASS|BEAM|FRAME', name_in_deck(scene%system%model, body))
      if (block > 0) origin = scene%deck%blocks(block)%origin_of('NAME')
   end function place_of_body

   !> What the constraints leave free: degrees of freedom, rank, and the count of Gruebler.
   pure function mobility_line(found, inner) result(text)
      type(assembly_type), intent(in) :: found
      !> Number of joints between segments
      integer, intent(in) :: inner
      character(:), allocatable :: text
      text = as_text(found%rates)//' rates, '//as_text(found%equations)//' constraint equations'
      if (inner > 0) text = text//' ('//as_text(3*inner)//' of them between segments)'
      if (found%rank < found%equations) text = text//' of rank '//as_text(found%rank)
      text = text//': '//as_text(found%rates - found%rank)//' degrees of freedom'
      if (found%rates - found%rank == 1) text = text(:len(text) - len('degrees of freedom'))//'degree of freedom'
      if (found%rank == found%equations) return
      text = text//' (Gruebler counts '//as_text(found%rates - found%equations)//'); '
      if (found%redundancy%count > 0) text = text//as_text(found%redundancy%count)//' redundant'
      if (found%redundancy%count > 0 .and. found%singular%count > 0) text = text//', '
      if (found%singular%count > 0) text = text//as_text(found%singular%count)//' dependent at the start only'
   end function mobility_line

   !> Number of joints that beams in segments have between their pieces: welds of three equations each.
   pure integer function inner_joints(model) result(number)
      type(model_type), intent(in) :: model
      number = 0
      if (allocated(model%wholes)) number = sum(model%wholes%inner)
   end function inner_joints

   !> Wall seconds since a reading of `system_clock`.
   real(wp) function seconds_since(tick) result(seconds)
      !> Clock then [ticks]
      integer(long), intent(in) :: tick
      integer(long) :: now, rate
      call system_clock(now, rate)
      seconds = real(now - tick, wp)/real(rate, wp)
   end function seconds_since

   !> Saves or restores it.
   subroutine exchange_carried(self, snapshot)
      class(carried_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('q', self%q)
      call snapshot%keep('v', self%v)
      call snapshot%keep('angle', self%angle)
      call snapshot%exchange('balanced', self%balanced)
      call snapshot%keep('lambda', self%lambda)
      call snapshot%exchange('rotation', self%rotation)
      call snapshot%exchange('centre', self%centre)
   end subroutine exchange_carried

end module limber_scene_scene
