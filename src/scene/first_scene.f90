!> From a deck to a system at its first state. Deck -> model -> modes -> system -> assembly. Errors come back as text that points
!> into the deck. Floor: scene.
module limber_scene_first_scene
   use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_get_status, ieee_set_status, ieee_set_halting_mode, ieee_all
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_text, only: as_text, newline
   use limber_scene_damping_check, only: damping_warning
   use limber_scene_law_checks, only: check_laws
   use limber_scene_kinematic_determinacy, only: refuse_undriven
   use limber_scene_integrator_choice, only: choose_integrator
   use limber_scene_speed_jumps, only: begin_behind
   use limber_scene_scene, only: scene_type, place_of, place_of_body, starts_with_dynamics, seconds_since
   use limber_scene_start_warnings, only: warn_of_redundancy, warn_of_turn, warn_of_springs, warn_of_changes, &
      & warn_of_supports
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_deck_parameters, only: override_type
   use limber_deck_reader, only: read_deck
   use limber_beam_reduction_cache, only: library_type
   use limber_model_build, only: build_model
   use limber_model_beam_segments, only: name_in_deck
   use limber_model_model, only: model_type
   use limber_multibody_assembly, only: first_guess, assemble
   use limber_multibody_hanging_loads, only: first_push, hang_bodies
   use limber_multibody_driven_motion, only: driven_motion_type, new_held, balance_deflections
   use limber_multibody_constraint_rank, only: assembly_type
   use limber_multibody_drivers, only: driven_angle_type
   use limber_multibody_redundant_constraints, only: redundancy_type, find_redundancy, constraint_names
   use limber_multibody_first_deflections, only: balance_start
   use limber_multibody_start_rates, only: follow_balance
   use limber_multibody_control_states, only: start_states
   use limber_multibody_compliant_constraints, only: soften_constraints
   use limber_multibody_massless, only: find_massless
   use limber_multibody_joint_misfit, only: bend_least
   use limber_multibody_modal_damping, only: any_modal, find_damping, damped_modes_type
   use limber_multibody_kinematics, only: move_frames, place_frames
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix, fill
   use limber_multibody_beam_supports, only: find_supports
   use limber_multibody_system, only: new_system, new_workspace
   implicit none
   private
   public :: read_scene, build_scene, settle_integrator

contains

   !> Reads, builds and assembles.
   subroutine read_scene(path, scene, error, overrides, library)
      !> The deck
      character(*), intent(in) :: path
      type(scene_type), intent(out) :: scene
      !> Everything that is wrong with the deck, rendered; status 2
      type(error_type), allocatable, intent(out) :: error
      !> Values of parameters in place of those of the deck
      type(override_type), intent(in), optional :: overrides(:)
      !> Reductions of beams that need not be made again; those of this scene are added
      type(library_type), intent(inout), optional :: library
      type(diagnostics_type) :: diagnostics
      integer(long) :: tick
      call system_clock(tick)
      call read_deck(path, scene%deck, diagnostics, overrides)
      scene%reading = seconds_since(tick)
      call build_scene(scene, diagnostics, error, library)
   end subroutine read_scene

   !> Builds and assembles what the deck of the scene describes.
   subroutine build_scene(scene, diagnostics, error, library)
      !> With its deck; receives the rest
      type(scene_type), intent(inout) :: scene
      !> Of the reading of the deck
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Everything that is wrong with the deck, rendered; status 2
      type(error_type), allocatable, intent(out) :: error
      !> Reductions of beams that need not be made again; those of this scene are added
      type(library_type), intent(inout), optional :: library
      class(model_type), allocatable :: model
      integer(long) :: tick
      call system_clock(tick)
      allocate (model_type :: model)
      if (scene%deck%is_whole) call build_model(scene%deck, model, diagnostics, library)
      scene%building = seconds_since(tick)
      if (diagnostics%count == 0 .and. starts_with_dynamics(model)) call check_laws(model, scene%deck, diagnostics)
      if (diagnostics%count == 0) then
         call system_clock(tick)
         scene%system = new_system(model)
         call new_workspace(scene%system, scene%work)
         call assemble_scene(scene, diagnostics)
         if (diagnostics%count == 0 .and. starts_with_dynamics(model)) call check_masses(scene, diagnostics)
         if (diagnostics%count == 0) call refuse_undriven(scene, diagnostics)
         scene%assembling = seconds_since(tick)
         if (diagnostics%count == 0 .and. starts_with_dynamics(model)) call settle_integrator(scene)
      end if
      scene%warnings = diagnostics%render(scene%deck%source)
      if (diagnostics%count > 0) call raise(error, scene%warnings, status_deck)
      if (diagnostics%warnings > 0) scene%warnings = scene%warnings//newline
   end subroutine build_scene

   !> A body without inertia that is free to move has no motion that could be found.
   subroutine check_masses(scene, diagnostics)
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: origin
      character(:), allocatable :: name
      integer :: body, block
      logical :: turns
      call find_massless(scene%system, scene%work, scene%system%model%dynamics%start, scene%q, body, turns)
      if (body == 0) return
      name = name_in_deck(scene%system%model, body)
      origin = origin_type(file=1)
      block = scene%deck%find_named('RIGID BODY|POINT MASS|BEAM|FRAME', name)
      if (block > 0) origin = scene%deck%blocks(block)%origin_of('NAME')
      if (turns) then
         call diagnostics%add(origin, "body '"//name//"' has no moment of inertia, and its joints leave it free to turn", &
            & 'give it INERTIA=, or a joint or driver that holds its rotation; what need not turn is a *POINT MASS')
      else
         call diagnostics%add(origin, "body '"//name//"' has no mass, and its joints leave it free to move", &
            & 'give it MASS=, however small, or joints or drivers that hold it')
      end if
   end subroutine check_masses

   !> Chooses the integrator where the deck leaves it open.
   subroutine settle_integrator(scene)
      type(scene_type), intent(inout) :: scene
      character(:), allocatable :: integrator, reason
      if (.not. scene%system%model%dynamics%wanted) return
      if (scene%system%model%dynamics%integrator /= 'AUTO') return
      call choose_integrator(scene%system, scene%work, scene%q, scene%v, integrator, reason)
      scene%system%model%dynamics%integrator = integrator
      scene%system%model%dynamics%reason = reason
   end subroutine settle_integrator

   !> First state; what cannot be assembled, or is redundant, is shown at the joint or driver in the deck.
   subroutine assemble_scene(scene, diagnostics)
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable :: error
      integer :: culprit
      allocate (scene%q(scene%system%layout%nq), scene%v(scene%system%layout%nq))
      associate (model => scene%system%model)
         call first_guess(scene%system, model%dynamics%start, scene%q, scene%v)
         call assemble(scene%system, scene%work, model%dynamics%start, scene%q, scene%v, error, culprit, scene%assembly)
         scene%begin = model%dynamics%start
         if (.not. allocated(error) .and. starts_with_dynamics(model)) call begin_anew(scene, error, culprit)
      end associate
      if (allocated(error)) then
         call diagnostics%add(place_of(scene, culprit), error%message)
         return
      end if
      if (scene%assembly%bends) call bend_bodies(scene, diagnostics)
      call warn_of_redundancy(scene, diagnostics)
      call refuse_turns_apart(scene, diagnostics)
      call warn_of_turn(scene, diagnostics)
      call warn_of_changes(scene, diagnostics)
      call warn_of_springs(scene, diagnostics)
      call warn_of_supports(scene, diagnostics)
      call damp_modes(scene, diagnostics)
      call find_supports(scene%system, scene%work, scene%q)
      if (scene%assembly%rank < scene%assembly%equations) then
         call soften_constraints(scene%system)
         call new_workspace(scene%system, scene%work)
      end if
      call start_states(scene%system, scene%work, scene%begin, scene%q, scene%v)
      call begin_energies(scene)
      if (scene%system%model%assembly%static_deflections) call settle_deflections(scene, diagnostics)
   end subroutine assemble_scene

   !> From where the energy of each load is counted.
   subroutine begin_energies(scene)
      type(scene_type), intent(inout) :: scene
      type(ieee_status_type) :: status
      integer :: i
      associate (system => scene%system, kinematics => scene%work%kinematics)
         call place_frames(system%model, system%layout, scene%begin, scene%q, kinematics)
         call move_frames(system%model, system%layout, scene%q, scene%v, kinematics)
         ! Laws are tried where they may have no value
         call ieee_get_status(status)
         call ieee_set_halting_mode(ieee_all, .false.)
         do i = 1, size(system%loads)
            call system%loads(i)%item%begin_energy(kinematics)
         end do
         call ieee_set_status(status)
      end associate
   end subroutine begin_energies

   !> Shape of least energy where joints bend bodies, and a word if that is more than figures of the deck that are rounded.
   subroutine bend_bodies(scene, diagnostics)
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), parameter :: rounded = 1.0e-5_wp
      type(assembly_type) :: again
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      real(wp) :: most, bent
      integer :: i, body, culprit
      logical :: done
      associate (system => scene%system, start => scene%begin)
         call bend_least(system, start, scene%q, scene%v, done)
         if (done) call assemble(system, scene%work, start, scene%q, scene%v, error, culprit, again)
         most = 0.0_wp
         body = 0
         do i = 1, size(system%layout%q)
            associate (own => scene%q(system%layout%q(i) + 4:system%layout%q(i) + 3 + system%layout%n(i)))
               if (size(own) == 0) cycle
               bent = maxval(abs(own))*system%model%bodies(i)%largest_shape/system%model%bodies(i)%size
            end associate
            if (.not. bent > most) cycle
            most = bent
            body = i
         end do
         if (most < rounded) return
         text = "body '"//name_in_deck(system%model, body)//"' starts bent, for its joints do not meet it as it is given: "
         if (done) then
            call diagnostics%warn(place_of_body(scene, body), text//'it has the shape of least strain energy that closes them', &
               & 'if that is not meant, correct the places of its joints; it may bend to the other side as well, which a small'// &
               & ' CURVATURE decides')
         else
            call diagnostics%warn(place_of_body(scene, body), text//'no equilibrium of its shape is found, and it may vibrate', &
               & 'start with *STATICS, or correct the places of its joints')
         end if
      end associate
   end subroutine bend_bodies

   !> Assembles again for the instant right behind the start where a driver changes its speed right there.
   subroutine begin_anew(scene, error, culprit)
      type(scene_type), intent(inout) :: scene
      type(error_type), allocatable, intent(out) :: error
      integer, intent(inout) :: culprit
      real(wp) :: jumps(size(scene%system%constraints))
      call begin_behind(scene%system, scene%work, scene%q, .false., scene%begin, jumps, error)
      if (allocated(error) .or. .not. scene%begin > scene%system%model%dynamics%start) return
      call first_guess(scene%system, scene%begin, scene%q, scene%v)
      call assemble(scene%system, scene%work, scene%begin, scene%q, scene%v, error, culprit, scene%assembly)
   end subroutine begin_anew

   !> Drivers that turn one body to angles a turn apart: its direction is the same, its angle is not.
   subroutine refuse_turns_apart(scene, diagnostics)
      type(scene_type), intent(in) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), parameter :: turn = 2*acos(-1.0_wp)
      integer :: i, k, first(size(scene%work%bodies))
      real(wp) :: apart
      first = 0
      do i = 1, size(scene%system%constraints)
         select type (item => scene%system%constraints(i)%item)
         type is (driven_angle_type)
            associate (drives => scene%work%kinematics%drives, body => item%bodies(1))
               k = first(body)
               if (k == 0) first(body) = item%drive
               if (k == 0) cycle
               apart = drives(item%drive)%value - drives(k)%value
               if (nint(apart/turn) == 0) cycle
               call diagnostics%add(place_of(scene, i), item%label//" turns body '"//scene%system%model%bodies(body)%name// &
                  & "' to an angle that is "//as_text(nint(apart/turn))//" turn(s) from that of driver '"// &
                  & scene%system%model%drivers(k)%name//"' at the start", 'give both the same angle')
            end associate
         end select
      end do
   end subroutine refuse_turns_apart

   !> Damping ratios are those of the modes of a body as the scene holds it, which is known from here on.
   subroutine damp_modes(scene, diagnostics)
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      class(model_type), allocatable :: model
      type(damped_modes_type) :: modes
      character(:), allocatable :: text, hint
      logical, allocatable :: missed(:)
      integer :: i, body
      if (.not. any_modal(scene%system%model)) return
      allocate (model, source=scene%system%model)
      call find_damping(scene%system, scene%work, model, scene%q, missed, modes)
      do i = 1, size(missed)
         if (.not. missed(i)) cycle
         ! Of a beam in pieces once
         if (i > 1 .and. model%bodies(i)%whole > 0) then
            if (model%bodies(i - 1)%whole == model%bodies(i)%whole) cycle
         end if
         call diagnostics%warn(damping_origin(scene, i), "damping of '"//name_in_deck(model, i)//"' is that of its"// &
            & ' coordinates, not of its modes as the scene holds it: the scene is too large to find these', &
            & 'RAYLEIGH BETA means the same in any coordinates')
      end do
      call damping_warning(model, modes, body, text, hint)
      if (body > 0) call diagnostics%warn(damping_origin(scene, body), text, hint)
      scene%system = new_system(model)
      call new_workspace(scene%system, scene%work)
   end subroutine damp_modes

   !> Where the damping of a body stands in the deck.
   pure function damping_origin(scene, body) result(origin)
      type(scene_type), intent(in) :: scene
      integer, intent(in) :: body
      type(origin_type) :: origin
      integer :: i
      origin = origin_type(file=1)
      do i = 1, size(scene%deck%blocks)
         if (scene%deck%blocks(i)%keyword /= 'DAMPING') cycle
         if (scene%deck%blocks(i)%name('BODY') == name_in_deck(scene%system%model, body)) origin = scene%deck%blocks(i)%origin
      end do
   end function damping_origin

   !> Deflections in equilibrium at the first time: with free frames by their own stiffness, and where drivers hold all frames
   !> together with the joints.
   subroutine settle_deflections(scene, diagnostics)
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(driven_motion_type) :: held
      !> Acceleration of bodies beside that of gravity
      real(wp), parameter :: noticed = 1.0e-6_wp
      !> Vibrations by rates that are left out, of a deflection, that are told
      real(wp), parameter :: told = 0.04_wp
      real(wp), allocatable :: q(:), v(:), a(:)
      character(:), allocatable :: names, why
      real(wp) :: push, left, share
      logical :: done, driven, followed
      left = 0.0_wp
      driven = .false.
      followed = .true.
      share = 0.0_wp
      if (max(scene%deck%find('BEAM'), scene%deck%find('FRAME')) == 0) then
         call diagnostics%warn(scene%deck%blocks(scene%deck%find('ASSEMBLY'))%origin_of('INITIAL DEFLECTIONS'), &
            & 'no body of the deck deflects: bodies start where they are given, in balance or not', &
            & 'let *STATICS find a balance before this analysis, or give bodies the X, Y, ANGLE that it finds')
         return
      end if
      allocate (q, source=scene%q)
      allocate (v, source=scene%v)
      allocate (a, source=scene%v)
      associate (start => scene%system%model%dynamics%start)
         call new_held(scene%system, held)
         ! Where deflections alone give way to joints, those of held deflections have no grip: what is found is found by chance
         call find_unheld(scene, start, names)
         done = .false.
         if (names == '') then
            push = first_push(scene%system, scene%work, held, start, q, v)
            call balance_start(scene%system, scene%work, held, start, q, v, done)
            if (done) call hang_bodies(scene%system, scene%work, held, start, push, q, left)
         end if
         ! Where no frame is free all are in equilibrium together
         if (.not. done .and. scene%system%nc >= sum(scene%system%layout%rates)) then
            q = scene%q
            call balance_deflections(scene%system, scene%work, held, start, q, v, a, done)
            driven = done
         end if
         if (done) then
            a = v
            call follow_balance(scene%system, scene%work, held, start, driven, q, a, share, followed)
         end if
      end associate
      if (.not. done) then
         why = 'the motion is too fast for them to follow; use ZERO or GIVEN'
         if (names /= '') why = names//' ask more of the bodies than these can do without deflections, as a rod along a beam'// &
            & ' does; use ZERO, which starts with the shape of least strain energy where they bend bodies, or *STATICS first'
         call diagnostics%add(scene%deck%blocks(scene%deck%find('ASSEMBLY'))%origin_of('INITIAL DEFLECTIONS'), &
            & 'no equilibrium of the deflections is found', why)
         return
      end if
      associate (model => scene%system%model)
         if (left*model%length > noticed*norm2(model%gravity)) call diagnostics%warn(scene%deck%blocks( &
            & scene%deck%find('ASSEMBLY'))%origin_of('INITIAL DEFLECTIONS'), 'bodies that hang in balance where the deck has'// &
            & ' them do not where deflections take them, and start to swing: no equilibrium of all is found nearby', &
            & 'let *STATICS, PERIOD=0, RAMP=NO find it before this analysis, or damp the swing')
      end associate
      associate (block => scene%deck%blocks(scene%deck%find('ASSEMBLY')))
         if (scene%system%model%assembly%following) then
            v = a
            if (.not. followed) call diagnostics%warn(block%origin_of('INITIAL DEFLECTIONS'), 'deflections start in balance,'// &
               & ' but at rest: no balance is found right behind the start', 'start where the motion is slower')
         else if (share > told) then
            call diagnostics%warn(block%origin_of('INITIAL DEFLECTIONS'), 'deflections start in balance, but at rest in frames'// &
               & ' whose motion goes on to change that balance: vibrations of about '//as_text(100*share, 2)//' % of a'// &
               & ' deflection begin', 'let INITIAL DEFLECTIONS=FOLLOWING start them with the rates of their balance')
         end if
      end associate
      scene%q = q
      scene%v = v
   end subroutine settle_deflections

   !> Names of constraints that are not independent of one another as long as deflections are held; empty if there are none.
   subroutine find_unheld(scene, t, names)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      character(:), allocatable, intent(out) :: names
      type(constraint_matrix_type) :: frames
      type(redundancy_type) :: found
      names = ''
      associate (system => scene%system, work => scene%work)
         if (system%nc == 0) return
         call place_constraints(system, work, t, scene%q)
         call new_constraint_matrix(system, .false., frames)
         call fill(system, work, frames)
         call find_redundancy(system, frames, found)
         if (found%count > scene%assembly%equations - scene%assembly%rank) names = constraint_names(system, found%group > 0)
      end associate
   end subroutine find_unheld

end module limber_scene_first_scene
