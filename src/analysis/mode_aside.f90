!> Check of frequencies by a second scene. The scene is built aside with more of them, responses to all that acts and more modes,
!> its vibrations about the same state are found, and both lists are compared in order. A remedy is tried before it is named. Floor:
!> analysis. Source: doc/theory, eqs. (7.49), (7.50).
module limber_analysis_mode_aside
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_analysis_scene_aside, only: aside_type, build_aside, place_aside, additional_modes, add_missed
   use limber_analysis_richer_scene, only: richer_words, can_enrich, project_coordinates, nothing_more, with_responses, &
      & with_modes, with_both, with_functions
   use limber_scene_scene, only: scene_type
   use limber_analysis_small_motions, only: linearise_state, lowest_vibrations, undamped_terms
   use limber_model_model, only: analysis_step_type
   use limber_model_beam_segments, only: name_in_deck
   use limber_multibody_equilibrium, only: equilibrium_type
   use limber_multibody_system, only: system_type
   use limber_multibody_sparse_eigenmodes, only: is_large
   use limber_multibody_tangent, only: tangent_type
   use limber_multibody_tangent_products, only: times_mass
   use limber_multibody_small_vibrations, only: vibrations_type
   implicit none
   private
   public :: compare_aside, compare_functions
   public :: rich_type, look_aside, look_at_most, mapped_shapes, parts_of, speed_of, size_words

   !> Largest relative error of a frequency that is not told, and above which it is only told as more than that
   real(wp), parameter :: little = 0.02_wp, beyond = 0.5_wp
   !> A vibration with less of its modal mass than this in the modes of the list that are at most so much faster is not in the list
   real(wp), parameter :: least_part = 0.5_wp, nearby = 1.3_wp
   !> Vibrations beside those that are listed; additional modes that are tried at least
   integer, parameter :: beside = 6, least = 3

   !> The scene with more coordinates, and its vibrations
   type, extends(aside_type) :: rich_type
      type(vibrations_type) :: vibrations
      logical :: done = .false.
   end type rich_type

   !> What is wrong with a list
   type :: verdict_type
      !> Largest error of a frequency in order, of which mode, and the number of others that err too much
      real(wp) :: error = 0.0_wp
      integer :: mode = 0, others = 0
      !> The first vibration that is not in the list at all; 0: none
      integer :: lacking = 0
   end type verdict_type

contains

   !> Compares the modes of a scene with those of more coordinates; text: a warning with size, body and remedy, or empty.
   subroutine compare_aside(scene, step, balance, own, listed, text)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Linearised at the state
      type(equilibrium_type), intent(inout) :: balance
      !> Those that are listed first, and some more, without damping; the number of those that are listed
      type(vibrations_type), intent(in) :: own
      integer, intent(in) :: listed
      character(:), allocatable, intent(out) :: text
      type(rich_type), allocatable :: rich
      type(verdict_type) :: verdict
      integer :: level(size(scene%system%model%bodies)), extra, damping, body
      text = ''
      level = merge(with_both, nothing_more, can_enrich(scene%system%model%bodies))
      if (listed == 0 .or. all(level == nothing_more)) return
      damping = undamped_terms(balance)
      extra = additional_modes(scene%system, level, listed + beside)
      call look_at_most(scene, step, damping, level, extra, rich)
      if (.not. rich%done) then
         if (any(scene%system%model%bodies%is_frame)) text = "warning: modes of *MODES '"//step%name//"' are not compared with"// &
            & ' those of more coordinates, for which the frame has too few finite elements; use more DIVISIONS'//newline
         return
      end if
      call judge(scene%system, own, listed, rich, verdict)
      if (verdict%error <= little) return
      body = worst_body(scene%system, rich, merge(verdict%lacking, verdict%mode, verdict%lacking > 0))
      text = words(scene, own, rich, verdict, body, step)//remedy()//newline

   contains

      !> The first of the remedies that cures the list.
      function remedy() result(cure)
         character(:), allocatable :: cure
         type(rich_type), allocatable :: trial
         integer :: choice
         do choice = with_responses, with_modes
            if (richer_words(scene, body, choice, extra) == '') cycle
            level(body) = choice
            allocate (trial)
            call look_aside(scene, step, damping, level, extra, trial)
            if (trial%done) trial%done = largest_error(trial%vibrations, rich%vibrations, listed) <= little
            if (trial%done) exit
            deallocate (trial)
         end do
         cure = '; use '//richer_words(scene, body, choice, extra)
      end function remedy

   end subroutine compare_aside

   !> By how much the frequencies that are listed are too high for want of functions of exact beams, relative, in order.
   subroutine compare_functions(scene, step, balance, own, listed, error, done)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Linearised at the state
      type(equilibrium_type), intent(inout) :: balance
      !> As of `compare_aside`
      type(vibrations_type), intent(in) :: own
      integer, intent(in) :: listed
      real(wp), allocatable, intent(out) :: error(:)
      !> Whether there is a scene with more functions, with as many modes
      logical, intent(out) :: done
      type(rich_type), allocatable :: rich
      integer :: level(size(scene%system%model%bodies))
      allocate (error(0))
      done = .not. is_large(scene%system)
      if (.not. done) return
      level = merge(with_functions, nothing_more, scene%system%model%bodies%reduced%is_exact)
      allocate (rich)
      call look_aside(scene, step, undamped_terms(balance), level, 0, rich)
      done = rich%done
      if (done) done = min(size(rich%vibrations%frequency), size(own%frequency)) >= listed
      if (done) error = errors_in_order(own, rich%vibrations, listed)
   end subroutine compare_functions

   !> Builds the scene with more coordinates, places it where the scene is, and finds its vibrations there.
   subroutine look_aside(scene, step, damping, level, extra, rich)
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Velocity terms that count; what each body gets (bodies); number of additional modes
      integer, intent(in) :: damping, level(:), extra
      type(rich_type), intent(inout) :: rich
      type(error_type), allocatable :: error
      real(wp), allocatable :: lambda(:)
      logical :: done
      call build_aside(scene, level, extra, .false., rich%aside_type, done)
      if (.not. done) return
      associate (last => scene%last, new => rich%scene)
         allocate (lambda(scene%system%nc), source=0.0_wp)
         if (last%balanced) lambda = last%lambda
         call place_aside(scene, step%dynamics%start, scene%q, lambda, last%balanced, last%rotation, last%centre, &
            & rich%aside_type, done)
         call linearise_state(new, step, rich%balance, done, error)
         if (.not. allocated(error)) call lowest_vibrations(new, rich%balance, damping, step%modes, beside, rich%vibrations, error)
      end associate
      rich%done = .not. allocated(error)
   end subroutine look_aside

   !> The same with as many additional modes as the meshes have room for.
   subroutine look_at_most(scene, step, damping, level, extra, rich)
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      !> As of `look_aside`
      integer, intent(in) :: damping, level(:)
      !> Number of additional modes: wanted, found
      integer, intent(inout) :: extra
      type(rich_type), allocatable, intent(out) :: rich
      do
         allocate (rich)
         call look_aside(scene, step, damping, level, extra, rich)
         if (rich%done .or. extra <= least) exit
         deallocate (rich)
         extra = max(least, extra/2)
      end do
   end subroutine look_at_most

   !> Largest relative error of frequencies in order.
   pure real(wp) function largest_error(vibrations, others, listed) result(largest)
      type(vibrations_type), intent(in) :: vibrations, others
      !> How many are compared
      integer, intent(in) :: listed
      real(wp) :: error(min(listed, size(vibrations%frequency), size(others%frequency)))
      error = errors_in_order(vibrations, others, size(error))
      largest = maxval([0.0_wp, error])
   end function largest_error

   !> By how much the first frequencies are too high, relative, in order (number): more coordinates lower them. Zero for motions
   !> that nothing resists.
   pure function errors_in_order(vibrations, others, number) result(error)
      type(vibrations_type), intent(in) :: vibrations, others
      integer, intent(in) :: number
      real(wp) :: error(number), own, other, none
      integer :: j
      error = 0.0_wp
      none = 0.0_wp
      do j = 1, number
         none = max(none, 1.0e-5_wp*speed_of(vibrations, j))
      end do
      do j = 1, number
         own = speed_of(vibrations, j)
         other = speed_of(others, j)
         if (max(own, other) <= none) cycle
         error(j) = 2*beyond
         if ((vibrations%frequency(j) > 0.0_wp .eqv. others%frequency(j) > 0.0_wp) .and. other > none) &
            & error(j) = min(max(0.0_wp, own/other - 1), 2*beyond)
      end do
   end function errors_in_order

   !> |s| of a vibration [1/time].
   pure real(wp) function speed_of(vibrations, j) result(speed)
      type(vibrations_type), intent(in) :: vibrations
      integer, intent(in) :: j
      speed = hypot(vibrations%frequency(j), vibrations%growth(j))
   end function speed_of

   !> Errors of the list in order, and the first vibration that has little of its modal mass in the modes near it: it is lacking,
   !> and those behind it are one place too far.
   subroutine judge(system, own, listed, rich, verdict)
      type(system_type), intent(in) :: system
      type(vibrations_type), intent(in) :: own
      integer, intent(in) :: listed
      type(rich_type), intent(in) :: rich
      type(verdict_type), intent(out) :: verdict
      real(wp) :: error(min(listed, size(rich%vibrations%frequency)))
      complex(wp), allocatable :: mapped(:, :)
      integer :: r, near
      error = errors_in_order(own, rich%vibrations, size(error))
      if (all(error <= little)) return
      verdict%mode = maxloc(error, dim=1)
      verdict%error = error(verdict%mode)
      verdict%others = count(error > little) - 1
      allocate (mapped, source=mapped_shapes(system, rich%scene%system, own%shape))
      do r = 1, size(error)
         if (error(r) <= little) cycle
         near = count([(speed_of(own, near) <= nearby*speed_of(rich%vibrations, r), near=1, size(mapped, 2))])
         if (sum(parts_of(rich%scene%system, rich%balance%tangent, mapped(:, :near), rich%vibrations%shape(:, r))) &
            & >= least_part) cycle
         verdict%lacking = r
         return
      end do
   end subroutine judge

   !> Shapes in the layout of more coordinates (nw, modes).
   function mapped_shapes(system, richer, shape) result(mapped)
      type(system_type), intent(in) :: system, richer
      !> (nw, modes)
      complex(wp), intent(in) :: shape(:, :)
      complex(wp) :: mapped(richer%layout%nw, size(shape, 2))
      real(wp) :: part(richer%layout%nw, 2)
      integer :: j
      do j = 1, size(shape, 2)
         call project_coordinates(system, richer, real(shape(:, j), wp), part(:, 1), rates=.true.)
         call project_coordinates(system, richer, aimag(shape(:, j)), part(:, 2), rates=.true.)
         mapped(:, j) = cmplx(part(:, 1), part(:, 2), wp)
      end do
   end function mapped_shapes

   !> Parts of the modal mass of a shape that are in others of unit modal mass.
   function parts_of(system, tangent, shapes, shape) result(part)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      !> (nw, modes), (nw)
      complex(wp), intent(in) :: shapes(:, :), shape(:)
      real(wp) :: part(size(shapes, 2)), product(size(shape), 2)
      integer :: j
      product = 0.0_wp
      call times_mass(system, tangent, 1.0_wp, real(shape, wp), product(:, 1))
      call times_mass(system, tangent, 1.0_wp, aimag(shape), product(:, 2))
      do j = 1, size(part)
         part(j) = abs(dot_product(shapes(:, j), cmplx(product(:, 1), product(:, 2), wp)))**2
      end do
   end function parts_of

   !> The body that has most strain energy of a vibration in coordinates that it lacks.
   integer function worst_body(system, rich, mode) result(body)
      type(system_type), intent(in) :: system
      type(rich_type), intent(in) :: rich
      !> Index of the vibration
      integer, intent(in) :: mode
      real(wp) :: energy(size(system%model%bodies))
      energy = 0.0_wp
      call add_missed(system, rich%scene%system, real(rich%vibrations%shape(:, mode), wp), energy)
      call add_missed(system, rich%scene%system, aimag(rich%vibrations%shape(:, mode)), energy)
      body = maxloc(energy, dim=1, mask=can_enrich(system%model%bodies))
   end function worst_body

   !> What is wrong, with which body.
   function words(scene, own, rich, verdict, body, step) result(text)
      type(scene_type), intent(in) :: scene
      type(vibrations_type), intent(in) :: own
      type(rich_type), intent(in) :: rich
      type(verdict_type), intent(in) :: verdict
      !> Its index
      integer, intent(in) :: body
      type(analysis_step_type), intent(in) :: step
      character(:), allocatable :: text
      associate (model => scene%system%model)
         text = 'warning: mode '//as_text(verdict%mode)//" of *MODES '"//step%name//"'"
         if (step%damped) text = text//', at '//as_text(speed_of(own, verdict%mode), 4)//' rad/'//model%units%time// &
            & ' without damping,'
         if (verdict%others > 0) text = text//' (and '//as_text(verdict%others)//' more)'
         text = text//' errs in its frequency by '//size_words(verdict%error)//': '
         if (verdict%lacking > 0) text = text//'the list lacks a mode at about '// &
            & as_text(speed_of(rich%vibrations, verdict%lacking), 3)//' rad/'//model%units%time//'; '
         text = text//trim(merge('frame', 'beam ', model%bodies(body)%is_frame))//" '"//name_in_deck(model, body)// &
            & "' cannot take this shape with its "//as_text(model%bodies(body)%reduced%n)//' coordinates'
      end associate
   end function words

   !> A relative error; a large one is only a bound.
   function size_words(error) result(text)
      real(wp), intent(in) :: error
      character(:), allocatable :: text
      text = 'about '
      if (error > beyond) text = 'more than '
      text = text//as_text(100*min(error, beyond), 2)//' %'
   end function size_words

end module limber_analysis_mode_aside
