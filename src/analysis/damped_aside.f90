!> Check of damped vibrations by a second scene. Forces of dampers bend bodies in shapes that their coordinates may not have, which
!> vibrations without damping do not show: the damped vibrations of a scene with more coordinates, about the same state, are
!> matched with those that are listed by their shapes. Floor: analysis. Source: doc/theory, eqs. (6.8), (7.49), part 7, dampers.
module limber_analysis_damped_aside
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_analysis_mode_aside, only: rich_type, look_aside, look_at_most, mapped_shapes, parts_of, speed_of, &
      & size_words
   use limber_analysis_scene_aside, only: additional_modes, add_missed
   use limber_analysis_richer_scene, only: richer_words, can_enrich, nothing_more, with_responses, with_modes, with_both, &
      & with_functions
   use limber_scene_scene, only: scene_type
   use limber_model_beam_segments, only: name_in_deck
   use limber_model_model, only: analysis_step_type
   use limber_multibody_equilibrium, only: equilibrium_type
   use limber_multibody_small_vibrations, only: vibrations_type, all_damping
   use limber_multibody_sparse_eigenmodes, only: is_large
   implicit none
   private
   public :: compare_damped

   !> Errors that are not told: of a frequency, relative; of a damping ratio, relative and at least
   real(wp), parameter :: little = 0.02_wp, little_ratio = 0.1_wp, least_ratio = 2.0e-4_wp
   !> Part of the modal mass that a vibration shares with its like; vibrations beside those that are listed
   real(wp), parameter :: alike = 0.5_wp
   integer, parameter :: beside = 6

   !> What is wrong with a list
   type :: mismatch_type
      !> Relative error of the frequency and of the damping ratio of the worst mode, which one, and that of the second scene
      real(wp) :: error(2) = 0.0_wp
      integer :: mode = 0, like = 0, others = 0
      !> A vibration of the second scene within the list that is not in it; 0: none
      integer :: lacking = 0
   end type mismatch_type

contains

   !> Compares the damped vibrations of a scene whose dampers act on flexible bodies; text: a warning, or empty.
   subroutine compare_damped(scene, step, balance, own, listed, text)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Linearised at the state
      type(equilibrium_type), intent(in) :: balance
      !> With damping, those that are listed first; their number
      type(vibrations_type), intent(in) :: own
      integer, intent(in) :: listed
      character(:), allocatable, intent(out) :: text
      type(rich_type), allocatable :: rich
      type(mismatch_type) :: verdict
      integer :: level(size(scene%system%model%bodies)), extra, body
      text = ''
      if (listed == 0 .or. is_large(scene%system) .or. .not. any_damped(scene, balance)) return
      level = merge(with_both, nothing_more, can_enrich(scene%system%model%bodies))
      where (scene%system%model%bodies%reduced%is_exact) level = with_functions
      if (all(level == nothing_more)) return
      extra = additional_modes(scene%system, level, listed + beside)
      call look_at_most(scene, step, all_damping, level, extra, rich)
      if (.not. rich%done) return
      call judge(scene, own, listed, rich, verdict)
      if (verdict%like == 0) return
      body = worst_body(scene, rich, verdict%like)
      text = words(scene, step, own, rich, verdict, body)//remedy()//newline

   contains

      !> The first of the remedies that cures the list.
      function remedy() result(cure)
         character(:), allocatable :: cure
         type(rich_type), allocatable :: trial
         type(mismatch_type) :: left
         integer :: choice
         associate (choices => scene%system%model%bodies(body)%choice)
            if (level(body) == with_functions) then
               cure = '; use FUNCTIONS='//as_text(2*choices%exact%angles)
               return
            end if
         end associate
         do choice = with_responses, with_modes
            if (richer_words(scene, body, choice, extra) == '') cycle
            level(body) = choice
            allocate (trial)
            call look_aside(scene, step, all_damping, level, extra, trial)
            if (trial%done) call judge_lists(trial, rich, listed, left)
            if (trial%done .and. left%like == 0) exit
            deallocate (trial)
         end do
         cure = '; use '//richer_words(scene, body, min(choice, with_both), extra)
      end function remedy

   end subroutine compare_damped

   !> Whether loads that damp act on flexible bodies.
   pure logical function any_damped(scene, balance) result(any_one)
      type(scene_type), intent(in) :: scene
      type(equilibrium_type), intent(in) :: balance
      integer :: i, side
      any_one = .false.
      do i = 1, size(balance%tangent%loads)
         associate (item => scene%system%loads(i)%item)
            do side = 1, size(item%bodies)
               if (item%bodies(side) == 0) cycle
               if (scene%system%layout%n(item%bodies(side)) == 0) cycle
               if (size(balance%tangent%loads(i)%damping) == 0) cycle
               any_one = any_one .or. maxval(abs(balance%tangent%loads(i)%damping)) > 0.0_wp
            end do
         end associate
      end do
   end function any_damped

   !> The worst of the listed vibrations beside those of the second scene that share most of their modal mass.
   subroutine judge(scene, own, listed, rich, verdict)
      type(scene_type), intent(in) :: scene
      type(vibrations_type), intent(in) :: own
      integer, intent(in) :: listed
      type(rich_type), intent(in) :: rich
      type(mismatch_type), intent(out) :: verdict
      complex(wp), allocatable :: mapped(:, :)
      allocate (mapped, source=mapped_shapes(scene%system, rich%scene%system, own%shape(:, :listed)))
      call judge_shapes(own, mapped, rich, verdict)
   end subroutine judge

   !> The same of another scene with more coordinates.
   subroutine judge_lists(trial, rich, listed, verdict)
      type(rich_type), intent(in) :: trial, rich
      integer, intent(in) :: listed
      type(mismatch_type), intent(out) :: verdict
      complex(wp), allocatable :: mapped(:, :)
      allocate (mapped, source=mapped_shapes(trial%scene%system, rich%scene%system, &
         & trial%vibrations%shape(:, :min(listed, size(trial%vibrations%frequency)))))
      call judge_shapes(trial%vibrations, mapped, rich, verdict)
   end subroutine judge_lists

   subroutine judge_shapes(own, mapped, rich, verdict)
      type(vibrations_type), intent(in) :: own
      !> Shapes of the first vibrations in the layout of the second scene (nw, modes)
      complex(wp), intent(in) :: mapped(:, :)
      type(rich_type), intent(in) :: rich
      type(mismatch_type), intent(out) :: verdict
      real(wp) :: parts(size(mapped, 2), size(rich%vibrations%frequency)), error(2), largest
      integer :: j, r
      do r = 1, size(parts, 2)
         parts(:, r) = parts_of(rich%scene%system, rich%balance%tangent, mapped, rich%vibrations%shape(:, r))
      end do
      largest = maxval(hypot(own%frequency, own%growth))
      do j = 1, size(parts, 1)
         ! A motion that nothing resists
         if (speed_of(own, j) <= 1.0e-5_wp*largest) cycle
         r = maxloc(parts(j, :), dim=1)
         if (parts(j, r) < alike) r = minloc(abs(cmplx(own%growth(j), own%frequency(j), wp) &
            & - cmplx(rich%vibrations%growth, rich%vibrations%frequency, wp)), dim=1)
         error = errors(own, j, rich%vibrations, r)
         if (all(error <= [little, little_ratio])) cycle
         if (verdict%mode > 0) verdict%others = verdict%others + 1
         if (verdict%mode > 0 .and. maxval(error/[little, little_ratio]) <= maxval(verdict%error/[little, little_ratio])) cycle
         verdict%error = error
         verdict%mode = j
         verdict%like = r
      end do
      j = size(parts, 1)
      do r = 1, size(parts, 2)
         if (speed_of(rich%vibrations, r) > (1 - little)*speed_of(own, j) .or. sum(parts(:, r)) >= alike) cycle
         if (speed_of(rich%vibrations, r) <= 1.0e-5_wp*largest) cycle
         verdict%lacking = r
         if (verdict%mode == 0) verdict%like = r
         exit
      end do
   end subroutine judge_shapes

   !> Relative errors of a frequency and of its damping ratio.
   pure function errors(own, j, others, r) result(error)
      type(vibrations_type), intent(in) :: own, others
      integer, intent(in) :: j, r
      real(wp) :: error(2), speed(2), ratio(2)
      speed = max([speed_of(own, j), speed_of(others, r)], tiny(1.0_wp))
      ratio = -[own%growth(j), others%growth(r)]/speed
      error(1) = abs(own%frequency(j) - others%frequency(r))/speed(2)
      error(2) = abs(ratio(1) - ratio(2))/max(abs(ratio(2)), tiny(1.0_wp))
      if (abs(ratio(1) - ratio(2)) <= least_ratio) error(2) = 0.0_wp
   end function errors

   !> The body with most strain energy of a vibration in what it lacks.
   integer function worst_body(scene, rich, mode) result(body)
      type(scene_type), intent(in) :: scene
      type(rich_type), intent(in) :: rich
      integer, intent(in) :: mode
      real(wp) :: energy(size(scene%system%model%bodies))
      energy = 0.0_wp
      call add_missed(scene%system, rich%scene%system, real(rich%vibrations%shape(:, mode), wp), energy)
      call add_missed(scene%system, rich%scene%system, aimag(rich%vibrations%shape(:, mode)), energy)
      body = maxloc(energy, dim=1, mask=scene%system%layout%n > 0)
   end function worst_body

   !> What is wrong, with which body.
   function words(scene, step, own, rich, verdict, body) result(text)
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      type(vibrations_type), intent(in) :: own
      type(rich_type), intent(in) :: rich
      type(mismatch_type), intent(in) :: verdict
      integer, intent(in) :: body
      character(:), allocatable :: text
      associate (model => scene%system%model)
         text = "warning: the list of *MODES '"//step%name//"'"
         if (verdict%mode > 0) then
            text = 'warning: mode '//as_text(verdict%mode)//" of *MODES '"//step%name//"', at "// &
               & as_text(speed_of(own, verdict%mode), 4)//' rad/'//model%units%time//' with damping,'
            if (verdict%others > 0) text = text//' (and '//as_text(verdict%others)//' more)'
            text = text//' errs'
            if (verdict%error(1) > little) text = text//' in its frequency by '//size_words(verdict%error(1))
            if (all(verdict%error > [little, little_ratio])) text = text//' and'
            if (verdict%error(2) > little_ratio) text = text//' in its damping ratio by '//size_words(verdict%error(2))
            if (verdict%lacking > 0) text = text//', and the list'
         end if
         if (verdict%lacking > 0) text = text//' lacks a mode at about '//as_text(speed_of(rich%vibrations, verdict%lacking), 4)// &
            & ' rad/'//model%units%time
         text = text//': '//trim(merge('frame', 'beam ', model%bodies(body)%is_frame))//" '"//name_in_deck(model, body)// &
            & "' cannot take the shape in which dampers bend it with its "//as_text(model%bodies(body)%reduced%n)//' coordinates'
      end associate
   end function words

end module limber_analysis_damped_aside
