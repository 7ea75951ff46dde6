!> Provenance in a results file. The bodies as they were reduced, and the provenance of the run. Floor: analysis.
module limber_analysis_provenance
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_base_version, only: version, commit, compiler, compiler_options
   use limber_scene_outcome, only: outcome_type
   use limber_scene_envelopes, only: record_envelope
   use limber_scene_scalar_values, only: scalar_values
   use limber_monitor_model_ranges, only: record_indicators
   use limber_scene_scene, only: scene_type
   use limber_analysis_analysis_steps, only: passed_type
   use limber_deck_content, only: deck_type
   use limber_deck_effective, only: effective_deck
   use limber_integrator_statistics, only: step_statistics_type
   use limber_model_analyses, only: kind_names
   use limber_model_unit_rules, only: unit_text
   use limber_model_model, only: body_type, units_type, body_point, body_flexible, step_dynamics
   use limber_output_history, only: history_type
   use limber_output_motion_record, only: define_motion
   use limber_output_outline, only: geometry_of
   implicit none
   private
   public :: open_history, record_origin, record_outcome, record_steps

contains

   !> Creates the history with its time axis, its channels and, if it is asked for, the motion.
   subroutine open_history(scene, path, overwrite, history, error, unkept, resume)
      type(scene_type), intent(in) :: scene
      character(*), intent(in) :: path
      logical, intent(in) :: overwrite
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      !> Whether no file is made; false if absent
      logical, intent(in), optional :: unkept
      !> Samples after which a run goes on whose file is there; negative or absent: it begins
      integer, intent(in), optional :: resume
      integer :: i
      logical :: resumed
      resumed = .false.
      if (present(resume)) resumed = resume >= 0
      associate (model => scene%system%model)
         if (resumed) then
            call history%resume(path, resume, error)
         else
            call history%create(path, overwrite, version, error, unkept)
         end if
         if (.not. allocated(error)) call history%define_time(model%units%time, error)
         do i = 1, size(model%channels)
            if (allocated(error)) return
            call history%define_channel(model%channels(i)%name, 1, model%channels(i)%units, model%channels(i)%long_name, error)
            if (allocated(error) .or. resumed .or. model%channels(i)%reference == '') cycle
            call history%put_attribute('/channels/'//model%channels(i)%name, 'measured_from', model%channels(i)%reference, error)
         end do
         if (model%motion .and. .not. allocated(error)) &
            & call define_motion(geometry_of(model, scene%system%layout), model%units%length, history, error)
      end associate
      if (resumed .or. history%unkept) return
      if (.not. allocated(error)) call record_provenance(scene, history, error)
      if (.not. allocated(error)) call record_bodies(scene, history, error)
   end subroutine open_history

   !> Deck, effective deck, version, compiler.
   subroutine record_origin(deck, history, error)
      type(deck_type), intent(in) :: deck
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      if (history%unkept) return
      call history%put_text('/run/deck', deck%source%text_of(1, 1, size(deck%source%files(1)%lines)), error)
      if (.not. allocated(error)) call history%put_text('/run/effective_deck', effective_deck(deck), error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'limber_version', version, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'commit', commit, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'compiler', compiler, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'compiler_options', compiler_options, error)
   end subroutine record_origin

   !> The same, and warnings, integrator and degrees of freedom of a run.
   subroutine record_provenance(scene, history, error)
      type(scene_type), intent(in) :: scene
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      call record_origin(scene%deck, history, error)
      if (.not. allocated(error)) call history%put_text('/run/warnings', scene%warnings, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'heading', scene%system%model%heading, error)
      if (.not. any(scene%system%model%steps%kind == step_dynamics)) return
      if (.not. allocated(error)) call history%put_attribute('/run', 'integrator', scene%system%model%dynamics%integrator, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'integrator_reason', scene%system%model%dynamics%reason, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'tolerance', scene%system%model%dynamics%tolerance, error)
      associate (found => scene%assembly)
         if (.not. allocated(error)) call history%put_attribute('/run', 'rates', found%rates, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'constraint_equations', found%equations, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'redundant_equations', found%redundancy%count, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'dependent_at_start', found%singular%count, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'degrees_of_freedom', found%rates - found%rank, error)
      end associate
   end subroutine record_provenance

   !> Invariants, frequencies and shapes of every body.
   subroutine record_bodies(scene, history, error)
      type(scene_type), intent(in) :: scene
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      do i = 1, size(scene%system%model%bodies)
         if (scene%system%layout%carries(i)) cycle
         call record_body(scene%system%model%bodies(i), scene%system%model%units, history, error)
         if (allocated(error)) return
      end do
   end subroutine record_bodies

   subroutine record_body(body, units, history, error)
      type(body_type), intent(in) :: body
      type(units_type), intent(in) :: units
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: group
      group = '/bodies/'//body%name
      call history%put_real(group//'/mass', [body%reduced%mass], units%mass, 'mass', error)
      if (.not. allocated(error)) call history%put_attribute(group, 'fidelity', fidelity(body), error)
      if (allocated(error) .or. body%kind == body_point) return
      call history%put_real(group//'/first_moment', body%reduced%c0, unit_text([1, 0, 1], units), &
         & 'first moment of mass c0 in the body frame', error)
      if (.not. allocated(error)) call history%put_real(group//'/second_moment', [body%reduced%i0], unit_text([2, 0, 1], units), &
         & 'second moment of mass I0 about the origin of the frame', error)
      if (allocated(error) .or. body%reduced%n == 0) return
      call record_coordinates(body, units, group, history, error)
   end subroutine record_body

   !> Of a flexible body: frequencies, shapes at the nodes, invariants of the coordinates.
   subroutine record_coordinates(body, units, group, history, error)
      type(body_type), intent(in) :: body
      type(units_type), intent(in) :: units
      character(*), intent(in) :: group
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      call history%put_attribute(group, 'bending_coordinates', body%reduced%bending, error)
      if (.not. allocated(error)) call history%put_attribute(group, 'axial_coordinates', &
         & body%reduced%n - body%reduced%bending, error)
      if (allocated(body%note) .and. .not. allocated(error)) then
         if (body%note /= '') call history%put_attribute(group, 'left_out', body%note, error)
      end if
      if (allocated(error)) return
      if (body%reduced%is_exact) then
         call record_exact(body, units, group, history, error)
         return
      end if
      call history%put_real(group//'/frequency', sqrt(body%reduced%omega2), 'rad/'//units%time, &
         & 'circular frequency of each coordinate, bending first, then axial', error)
      if (allocated(error)) return
      if (body%is_frame) then
         call record_frame(body, units, group, history, error)
      else
         call record_beam(body, units, group, history, error)
      end if
      if (.not. allocated(error)) call history%put_real(group//'/c', body%reduced%c, 'sqrt('//units%mass//')', 'invariant C', error)
      if (.not. allocated(error)) call history%put_real(group//'/d', body%reduced%d, 'sqrt('//units%mass//') '//units%length, &
         & 'invariant d', error)
      if (.not. allocated(error)) call history%put_real(group//'/e', body%reduced%e, 'sqrt('//units%mass//') '//units%length, &
         & 'invariant e', error)
      if (.not. allocated(error)) call history%put_real(group//'/skew', body%reduced%skew, '1', 'invariant E', error)
   end subroutine record_coordinates

   !> Mesh and shapes of a beam.
   subroutine record_beam(body, units, group, history, error)
      type(body_type), intent(in) :: body
      type(units_type), intent(in) :: units
      character(*), intent(in) :: group
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      call history%put_attribute(group, 'elements', body%beam%elements, error)
      if (.not. allocated(error)) call history%put_attribute(group, 'geometric_elements', body%choice%geometric_elements, error)
      if (.not. allocated(error)) call history%put_real(group//'/nodes', body%field%s, units%length, &
         & 'coordinate of each node along the beam', error)
      if (.not. allocated(error)) call history%put_real(group//'/deflection_shapes', transpose(body%field%w), &
         & '1/sqrt('//units%mass//')', 'deflection of the nodes in each bending coordinate', error)
      if (.not. allocated(error)) call history%put_real(group//'/axial_shapes', transpose(body%field%u), &
         & '1/sqrt('//units%mass//')', 'axial displacement of the nodes in each axial coordinate', error)
   end subroutine record_beam

   !> Functions of an exact beam at its stations.
   subroutine record_exact(body, units, group, history, error)
      type(body_type), intent(in) :: body
      type(units_type), intent(in) :: units
      character(*), intent(in) :: group
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      associate (exact => body%reduced%exact)
         call history%put_attribute(group, 'angle_functions', exact%angles, error)
         if (.not. allocated(error)) call history%put_attribute(group, 'strain_functions', exact%strains - exact%shears, error)
         if (.not. allocated(error)) call history%put_attribute(group, 'shear_functions', exact%shears, error)
         if (.not. allocated(error)) call history%put_real(group//'/stations', exact%s, units%length, &
            & 'coordinate of each station along the undeformed axis', error)
         if (.not. allocated(error)) call history%put_real(group//'/angle_shapes', exact%psi, '1', &
            & 'section angle at the stations in each coordinate of the angle', error)
         if (.not. allocated(error) .and. exact%strains > 0) call history%put_real(group//'/strain_shapes', exact%chi(1, :, :), &
            & '1', 'strain at the stations in each coordinate of the strain', error)
      end associate
   end subroutine record_exact

   !> Mesh and shapes of a frame.
   subroutine record_frame(body, units, group, history, error)
      type(body_type), intent(in) :: body
      type(units_type), intent(in) :: units
      character(*), intent(in) :: group
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      call history%put_attribute(group, 'elements', size(body%mesh%member), error)
      if (.not. allocated(error)) call history%put_real(group//'/nodes', body%mesh%place, units%length, &
         & 'place of each node in the body frame', error)
      if (.not. allocated(error)) call history%put_real(group//'/element_nodes', real(body%mesh%ends, wp), '1', &
         & 'first and second node of each element, counted from 1', error)
      if (.not. allocated(error)) call history%put_real(group//'/shapes_x', transpose(body%shape(1, :, :)), &
         & '1/sqrt('//units%mass//')', 'displacement of the nodes along the first axis in each coordinate', error)
      if (.not. allocated(error)) call history%put_real(group//'/shapes_y', transpose(body%shape(2, :, :)), &
         & '1/sqrt('//units%mass//')', 'displacement of the nodes along the second axis in each coordinate', error)
      if (.not. allocated(error)) call history%put_real(group//'/shapes_rotation', transpose(body%shape(3, :, :)), &
         & '1/(sqrt('//units%mass//') '//units%length//')', 'rotation of the nodes in each coordinate', error)
   end subroutine record_frame

   !> Name of the fidelity of a body.
   pure function fidelity(body) result(name)
      type(body_type), intent(in) :: body
      character(:), allocatable :: name
      if (body%kind == body_point) then
         name = 'POINT MASS'
      else if (body%kind /= body_flexible) then
         name = 'RIGID'
      else if (body%reduced%is_exact) then
         name = 'EXACT'
      else if (body%reduced%geometric) then
         name = 'K_G'
      else
         name = 'LINEAR'
      end if
   end function fidelity

   !> What the analyses were, and which samples are theirs.
   subroutine record_steps(scene, passed, history, error)
      type(scene_type), intent(in) :: scene
      type(passed_type), intent(in) :: passed
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: names, kinds
      integer, allocatable :: steps(:)
      integer :: i, first
      allocate (steps(sum(passed%samples(:passed%count))))
      names = ''
      kinds = ''
      first = 1
      do i = 1, passed%count
         steps(first:first + passed%samples(i) - 1) = i
         first = first + passed%samples(i)
         if (i > 1) names = names//newline
         if (i > 1) kinds = kinds//newline
         names = names//scene%system%model%steps(i)%name
         kinds = kinds//trim(kind_names(scene%system%model%steps(i)%kind))
      end do
      call history%write_samples(error)
      if (.not. allocated(error)) call history%put_steps(steps, error)
      if (.not. allocated(error)) call history%put_text('/run/steps/names', names, error)
      if (.not. allocated(error)) call history%put_text('/run/steps/kinds', kinds, error)
      if (.not. allocated(error)) call history%put_real('/run/steps/start', passed%start(:passed%count), &
         & scene%system%model%units%time, 'first instant of each analysis', error)
      if (.not. allocated(error)) call history%put_real('/run/steps/end', passed%end(:passed%count), &
         & scene%system%model%units%time, 'last instant of each analysis', error)
   end subroutine record_steps

   !> Statistics of the run, and how it ended.
   subroutine record_outcome(scene, outcome, statistics, message, history, error)
      type(scene_type), intent(in) :: scene
      type(outcome_type), intent(in) :: outcome
      type(step_statistics_type), intent(in) :: statistics
      !> Empty if the run has finished
      character(*), intent(in) :: message
      type(history_type), intent(inout) :: history
      !> Allocated if it cannot be written; the history is closed in any case
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: ignored
      if (history%unkept) then
         call history%finish(message == '', message, error)
         return
      end if
      call put_counts()
      if (.not. allocated(error)) call put_seconds()
      if (.not. allocated(error)) call put_checks()
      if (.not. allocated(error)) call put_envelopes()
      if (.not. allocated(error)) call put_scalars()
      if (.not. allocated(error) .and. size(scene%system%model%events) > 0) call put_events()
      if (allocated(outcome%indicators) .and. .not. allocated(error)) call record_indicators(outcome%indicators, &
         & scene%system%model, history, error)
      if (.not. allocated(error)) call history%put_text('/run/warnings', scene%warnings, error)
      if (allocated(error)) then
         history%failed = .true.
         call history%finish(.false., message, ignored)
      else if (message == '') then
         call history%finish(.true., 'finished', error)
      else
         call history%finish(.false., message, error)
      end if

   contains

      subroutine put_scalars()
         real(wp), allocatable :: values(:)
         integer :: i
         allocate (values, source=scalar_values(scene%system%model, history))
         do i = 1, size(values)
            if (.not. allocated(error)) call history%put_real('/scalars/'//scene%system%model%scalars(i)%name, values(i:i), &
               & scene%system%model%scalars(i)%units, scene%system%model%scalars(i)%long_name, error)
         end do
      end subroutine put_scalars

      !> The table of events: names, and of each event met its time, which it is, its direction and all channels.
      subroutine put_events()
         character(:), allocatable :: names
         integer :: i
         associate (model => scene%system%model, met => outcome%events)
            names = model%events(1)%name
            do i = 2, size(model%events)
               names = names//newline//model%events(i)%name
            end do
            call history%put_text('/events/names', names, error)
            if (allocated(error) .or. met%count == 0) return
            call history%put_real('/events/time', met%times(), model%units%time, 'instant of each event', error)
            if (.not. allocated(error)) call history%put_integer('/events/event', met%indices(), &
               & 'which event, counted from 1 in the order of names', error)
            if (.not. allocated(error)) call history%put_integer('/events/direction', met%directions(), &
               & 'crossing upwards 1, downwards -1', error)
            if (size(model%switches) > 0) call put_turns()
            do i = 1, size(model%channels)
               if (.not. allocated(error)) call history%put_real('/events/channels/'//model%channels(i)%name, met%channel(i), &
                  & model%channels(i)%units, model%channels(i)%long_name, error)
            end do
         end associate
      end subroutine put_events

      !> Names of switches, and what each event has done to one.
      subroutine put_turns()
         character(:), allocatable :: names
         integer :: i
         associate (model => scene%system%model, met => outcome%events)
            names = model%switches(1)%name
            do i = 2, size(model%switches)
               names = names//newline//model%switches(i)%name
            end do
            if (.not. allocated(error)) call history%put_text('/events/switches', names, error)
            if (.not. allocated(error)) call history%put_integer('/events/switch', model%events(met%indices())%switch, &
               & 'which switch it may turn, counted from 1 in the order of switches; 0: none', error)
            if (.not. allocated(error)) call history%put_integer('/events/turned', met%turns(), &
               & 'switch turned on 1, off -1, not turned 0', error)
            if (.not. allocated(error)) call history%put_real('/events/energy', met%energies(), &
               & unit_text([2, -2, 1], model%units), &
               & 'change of the energy by the turn of the switch, or by the impact', error)
            if (allocated(error) .or. size(model%contacts) == 0) return
            call history%put_real('/events/impulse', met%impulses(), '', &
               & 'impulse of a rigid stop along its scalar, force or torque times time, positive where it pushes; else 0', error)
         end associate
      end subroutine put_turns

      subroutine put_counts()
         if (any(scene%system%model%steps%kind == step_dynamics)) then
            ! A run that has turned stiff has another one than it began with
            call history%put_attribute('/run', 'integrator', scene%system%model%dynamics%integrator, error)
            if (.not. allocated(error)) call history%put_attribute('/run', 'integrator_reason', &
               & scene%system%model%dynamics%reason, error)
            if (allocated(error)) return
         end if
         call history%put_attribute('/run', 'steps', statistics%steps, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'rejected_steps', statistics%rejected, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'failed_projections', statistics%failed_projections, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'right_hand_sides', statistics%evaluations, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'jacobians', statistics%jacobians, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'factorisations', statistics%factorisations, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'highest_order', statistics%highest_order, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'samples', outcome%samples, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'time_reached', outcome%reached, error)
         if (allocated(error) .or. statistics%steps == 0) return
         call history%put_attribute('/run', 'smallest_step', statistics%smallest_step, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'largest_step', statistics%largest_step, error)
      end subroutine put_counts

      subroutine put_envelopes()
         integer :: i
         if (.not. allocated(outcome%efforts)) return
         do i = 1, size(outcome%efforts)
            if (.not. allocated(error)) call record_envelope(scene%system%model, i, outcome%efforts, history, error)
         end do
      end subroutine put_envelopes

      subroutine put_seconds()
         call history%put_attribute('/run', 'seconds_reading', scene%reading, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'seconds_building', scene%building, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'seconds_assembling', scene%assembling, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'seconds_time_loop', outcome%wall, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'cpu_seconds_time_loop', outcome%cpu, error)
      end subroutine put_seconds

      subroutine put_checks()
         call history%put_attribute('/run', 'position_residual', outcome%position_residual, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'velocity_residual', outcome%velocity_residual, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'first_energy', outcome%first_energy, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'last_energy', outcome%last_energy, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'work', outcome%work, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'largest_energy', outcome%largest_energy, error)
         if (.not. allocated(error)) call history%put_attribute('/run', 'energy_imbalance', outcome%imbalance, error)
      end subroutine put_checks

   end subroutine record_outcome

end module limber_analysis_provenance
