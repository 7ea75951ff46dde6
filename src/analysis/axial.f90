!> Whether the axial coordinates of a beam may follow at rest (AXIAL DYNAMICS=STATIC): before a run from frequencies and loads,
!> during it from what is left out. Two numbers decide: the error that is to be expected of deflections, and the share of axial
!> waves in the deformation. Floor: analysis. Source: doc/theory, eqs. (146)-(149).
module limber_analysis_axial
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type
   use limber_base_finite, only: dsyev
   use limber_base_text, only: as_text
   use limber_analysis_choice, only: frame_rate
   use limber_model_breaks, only: break_times
   use limber_system_condensation, only: update_folds, place_axial_rates
   use limber_system_dynamics, only: linearise, accelerations, accelerate, sum_forces
   use limber_system_kinematics, only: place_frames, move_frames
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: axial_verdict_type, judge_axial, axial_watch_type, start_axial_watch, watch_axial, pass_axial_break, axial_findings

   !> Largest error that is put up with where no target is given, and largest share of axial waves in the deformation
   real(wp), parameter, public :: axial_target = 1.0e-2_wp, axial_share = 0.1_wp

   !> What is found of one body
   type :: axial_verdict_type
      !> True if the axial coordinates may follow at rest
      logical :: admissible = .true.
      !> Lowest frequency of stretching in the scene, with the masses that it moves; fastest change of axial forces [rad/time]
      real(wp) :: frequency = 0.0_wp, change = 0.0_wp
      !> Expected error of deflections, relative; share of axial waves in the deformation
      real(wp) :: error = 0.0_wp, share = 0.0_wp
      !> What decided, in words
      character(:), allocatable :: words
   end type axial_verdict_type

   !> One body in a run
   type :: axial_history_type
      !> Lowest frequency of stretching [rad/time]; axial displacement by which the first state is not at rest [length]
      real(wp) :: frequency = 0.0_wp, starting = 0.0_wp
      !> Loads at the last looks (axial, 3) and their times; how many there are
      real(wp), allocatable :: load(:, :)
      !> Scratch (axial)
      real(wp), allocatable :: lost(:)
      real(wp) :: t(3) = 0.0_wp
      integer :: looks = 0
      !> Largest so far: relative change of the first bending stiffness by tension that is left out; axial displacement that is left
      !> out, and of the stretch; deflection [length]
      real(wp) :: tension = 0.0_wp, wave = 0.0_wp, stretched = 0.0_wp, deflection = 0.0_wp
   end type axial_history_type

   !> All bodies in a run
   type :: axial_watch_type
      type(axial_history_type), allocatable :: bodies(:)
   contains
      procedure :: exchange => exchange_axial_watch
   end type axial_watch_type

contains

   !> Judges a body whose deck says STATIC at the first state of a scene.
   subroutine judge_axial(system, work, q, v, body, target, verdict)
      !> Left as it is
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> Assembled coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      !> Index of the body
      integer, intent(in) :: body
      !> Error of deflections that is put up with, relative
      real(wp), intent(in) :: target
      type(axial_verdict_type), intent(out) :: verdict
      type(error_type), allocatable :: error
      real(wp) :: a(size(q)), frequency(size(work%bodies)), missing(2), stretched, starting, slow, bent
      associate (model => system%model%bodies(body), reduced => system%model%bodies(body)%reduced, &
            & start => system%model%dynamics%start)
         if (.not. reduced%condensed) then
            verdict%words = 'has no axial coordinates that follow at rest'
            return
         end if
         call find_frequencies(system, work, q, frequency)
         verdict%frequency = frequency(body)
         if (verdict%frequency > 0.0_wp) call linearise(system, work, start, q, error)
         if (allocated(error) .or. .not. verdict%frequency > 0.0_wp) then
            verdict%admissible = .false.
            verdict%error = 1.0_wp
            verdict%share = 1.0_wp
            verdict%words = 'joints hold its ends, so that it cannot bend without stretching'
            return
         end if
         a = 0.0_wp
         call accelerations(system, work, q, v, a)
         slow = frame_rate(system, q, v, a)
         ! What the loads of the first state, let go there, would make it ring by
         call add_size(system, body, work%bodies(body)%load, stretched)
         starting = stretched + first_swing(system, work, q, v, body, verdict%frequency)
         stretched = max(stretched, rotation_stretch(system, body, slow))
         call look_at_loads(system, work, q, v, body, verdict%frequency, missing)
         call linearise(system, work, start, q, error)
         verdict%change = slow
         bent = 0.0_wp
         if (reduced%bending > 0) then
            bent = 0.1_wp*model%size*min(1.0_wp, slow**2/reduced%omega2(1))
            if (reduced%geometric) verdict%change = max(slow, 2*sqrt(reduced%omega2(1)))
         end if
         associate (ratio => (verdict%change/verdict%frequency)**2)
            verdict%error = grown(system, body, 0.1_wp*ratio + missing(1) + 2*stretched/model%size) &
               & + start_error(system, body, verdict%frequency, starting/max(stretched, tiny(stretched)))
            verdict%share = missing(2) + starting + min(1.0_wp, (slow/verdict%frequency)**2)*stretched
         end associate
         if (verdict%share > 0.0_wp) verdict%share = verdict%share/(verdict%share + bent)
      end associate
      call decide(system, target, verdict)
   end subroutine judge_axial

   !> Error of the deflections that forces make which are wrong by a part of the first bending stiffness: it grows with the number
   !> of vibrations, eq. (147).
   pure real(wp) function grown(system, body, part)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: part
      associate (reduced => system%model%bodies(body)%reduced, dynamics => system%model%dynamics)
         grown = part
         if (reduced%bending > 0) grown = part*(1 + 0.25_wp*sqrt(reduced%omega2(1))*(dynamics%end - dynamics%start) &
            & /(2*acos(-1.0_wp)))
      end associate
   end function grown

   !> Error of the deflections if the stretching of the first state is not that at rest, so that it would ring.
   pure real(wp) function start_error(system, body, frequency, starting)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      !> Lowest frequency of stretching; amplitude of the ringing relative to the stretch
      real(wp), intent(in) :: frequency, starting
      start_error = 0.0_wp
      associate (reduced => system%model%bodies(body)%reduced)
         if (reduced%bending > 0) start_error = min(1.0_wp, starting)*reduced%omega2(1)/frequency**2
      end associate
   end function start_error

   !> Decides from the numbers.
   pure subroutine decide(system, target, verdict)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: target
      type(axial_verdict_type), intent(inout) :: verdict
      character(:), allocatable :: unit
      unit = ' rad/'//system%model%units%time
      verdict%admissible = verdict%error <= target .and. verdict%share <= axial_share
      if (verdict%share > axial_share) then
         verdict%words = 'loads along it change too fast for its stretching at '//as_text(verdict%frequency, 3)//unit// &
            & ': axial waves make '//as_text(100*verdict%share, 2)//' % of its deformation'
      else
         verdict%words = 'axial forces change with '//as_text(verdict%change, 3)//unit//', its stretching follows at '// &
            & as_text(verdict%frequency, 3)//unit//': an error of about '//as_text(verdict%error, 2)//' is to be expected'
      end if
   end subroutine decide

   !> Frequency of the stretching of each body at the place q, the lowest ones of the scene in which it has a tenth, all else free
   !> to move as the joints let it, without stiffness of bending: from the accelerations of all axial coordinates under unit forces
   !> on them, eq. (146). Zero if joints hold the ends.
   subroutine find_frequencies(system, work, q, frequency)
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:)
      !> (bodies); zero where there are no such coordinates
      real(wp), intent(out) :: frequency(:)
      real(wp), parameter :: part = 0.1_wp, held = 1.0e-9_wp
      type(error_type), allocatable :: error
      logical :: condensed(size(frequency))
      integer, allocatable :: place(:), owner(:)
      real(wp) :: share
      real(wp), allocatable :: matrix(:, :), omega(:), value(:), force(:), push(:), room(:)
      integer :: i, j, k, n, info
      condensed = system%model%bodies%reduced%condensed
      allocate (place(0), owner(0), omega(0))
      do i = 1, size(frequency)
         if (.not. condensed(i)) cycle
         associate (reduced => system%model%bodies(i)%reduced)
            place = [place, (system%layout%w(i) + 2 + k, k=reduced%bending + 1, reduced%n)]
            owner = [owner, (i, k=reduced%bending + 1, reduced%n)]
            omega = [omega, sqrt(reduced%omega2(reduced%bending + 1:))]
         end associate
      end do
      n = size(place)
      allocate (matrix(n, n), value(n), force(system%layout%nw), push(system%layout%nw), room(max(1, 8*n)))
      system%model%bodies%reduced%condensed = .false.
      system%condensed = .false.
      call linearise(system, work, system%model%dynamics%start, q, error)
      do j = 1, n
         if (allocated(error)) exit
         force = 0.0_wp
         force(place(j)) = omega(j)
         call accelerate(system, work, force, push)
         matrix(:, j) = omega*push(place)
      end do
      system%model%bodies%reduced%condensed = condensed
      system%condensed = .true.
      frequency = 0.0_wp
      if (allocated(error) .or. n == 0) return
      matrix = 0.5_wp*(matrix + transpose(matrix))
      call dsyev('V', 'L', n, matrix, n, value, room, size(room), info)
      if (info /= 0) return
      do i = 1, size(frequency)
         share = 0.0_wp
         do j = 1, n
            share = share + sum(matrix(:, j)**2, mask=owner == i)
            if (share < part) cycle
            if (value(j) > held*value(n)) frequency(i) = sqrt(value(j))
            exit
         end do
      end do
   end subroutine find_frequencies

   !> What the loads' change in time leaves out, at the first place: relative change of the first bending stiffness by tension, and
   !> axial displacement [length].
   subroutine look_at_loads(system, work, q, v, body, frequency, missing)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:), v(:)
      integer, intent(in) :: body
      real(wp), intent(in) :: frequency
      real(wp), intent(out) :: missing(2)
      integer, parameter :: looks = 400
      real(wp), allocatable :: times(:), before(:), last(:), now(:), most(:), lost(:)
      real(wp) :: step, push
      integer :: k, n
      missing = 0.0_wp
      n = size(work%bodies(body)%load)
      allocate (before(n), last(n), now(n), most(n), lost(n))
      lost = 0.0_wp
      most = 0.0_wp
      before = 0.0_wp
      last = 0.0_wp
      associate (t0 => system%model%dynamics%start, t1 => system%model%dynamics%end)
         step = (t1 - t0)/looks
         do k = 0, looks
            call axial_forces(t0 + k*step, now)
            most = max(most, abs(now))
            if (k > 1) lost = max(lost, abs(now - 2*last + before)/(step*frequency)**2)
            before = last
            last = now
         end do
         lost = min(lost, 2*most)
         allocate (times, source=break_times(system%model))
         do k = 1, size(times)
            call axial_forces(nearest(times(k), -1.0_wp), last)
            call axial_forces(times(k), now)
            lost = max(lost, abs(now - last))
         end do
      end associate
      call add_size(system, body, lost, missing(2))
      call add_tension(system, body, lost, push)
      missing(1) = push

   contains

      subroutine axial_forces(t, force)
         real(wp), intent(in) :: t
         real(wp), intent(out) :: force(:)
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, v, work%kinematics)
         call sum_forces(system, work, q, v)
         force = work%bodies(body)%eta_force(system%model%bodies(body)%reduced%bending + 1:)
      end subroutine axial_forces

   end subroutine look_at_loads

   !> Largest axial displacement, as a sum over the coordinates, under forces on the axial coordinates.
   pure subroutine add_size(system, body, force, stretched)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: force(:)
      real(wp), intent(out) :: stretched
      integer :: k
      stretched = 0.0_wp
      associate (model => system%model%bodies(body), reduced => system%model%bodies(body)%reduced)
         do k = 1, size(force)
            stretched = stretched + abs(force(k))/reduced%omega2(reduced%bending + k)*maxval(abs(model%field%u(:, k)))
         end do
      end associate
   end subroutine add_size

   !> Relative change of the first bending stiffness by the tension that forces on the axial coordinates make.
   pure subroutine add_tension(system, body, force, part)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: force(:)
      real(wp), intent(out) :: part
      part = 0.0_wp
      associate (reduced => system%model%bodies(body)%reduced)
         if (reduced%geometric) part = 2*abs(dot_product(reduced%fold(:, 1), force))/reduced%omega2(1)
      end associate
   end subroutine add_tension

   !> Stretch of a body that turns with a speed about the origin of its frame.
   pure real(wp) function rotation_stretch(system, body, speed) result(stretched)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: speed
      associate (reduced => system%model%bodies(body)%reduced)
         call add_size(system, body, speed**2*reduced%d(reduced%bending + 1:), stretched)
      end associate
   end function rotation_stretch

   !> Amplitude of the axial vibration that velocities of the first state would make [length].
   real(wp) function first_swing(system, work, q, v, body, frequency) result(swing)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:), v(:)
      integer, intent(in) :: body
      real(wp), intent(in) :: frequency
      real(wp) :: rate(size(v))
      integer :: first, last, k
      rate = v
      call update_folds(system, work, q)
      call place_axial_rates(system, work, rate)
      swing = 0.0_wp
      associate (model => system%model%bodies(body))
         first = system%layout%q(body) + 3 + model%reduced%bending
         last = system%layout%q(body) + 3 + model%reduced%n
         do k = 1, last - first
            swing = swing + abs(rate(first + k) - v(first + k))/frequency*maxval(abs(model%field%u(:, k)))
         end do
      end associate
   end function first_swing

   !> Begins to watch at the first state of a run, before its axial coordinates are put where they belong.
   subroutine start_axial_watch(watch, system, work, q, v)
      type(axial_watch_type), intent(inout) :: watch
      !> Left as it is
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      type(error_type), allocatable :: error
      real(wp) :: frequency(size(work%bodies)), a(size(q))
      integer :: i
      allocate (watch%bodies(size(work%bodies)))
      if (.not. system%condensed) return
      call find_frequencies(system, work, q, frequency)
      call linearise(system, work, system%model%dynamics%start, q, error)
      if (.not. allocated(error)) call accelerations(system, work, q, v, a)
      do i = 1, size(watch%bodies)
         if (.not. system%model%bodies(i)%reduced%condensed) cycle
         watch%bodies(i)%frequency = frequency(i)
         allocate (watch%bodies(i)%load(size(work%bodies(i)%load), 3), watch%bodies(i)%lost(size(work%bodies(i)%load)))
         watch%bodies(i)%load = 0.0_wp
         if (allocated(error) .or. .not. frequency(i) > 0.0_wp) cycle
         call add_size(system, i, work%bodies(i)%load, watch%bodies(i)%starting)
         watch%bodies(i)%starting = watch%bodies(i)%starting + first_swing(system, work, q, v, i, frequency(i))
      end do
   end subroutine start_axial_watch

   !> Looks at the end of a step, at which the loads in the workspace are.
   pure subroutine watch_axial(watch, system, work, t, q)
      type(axial_watch_type), intent(inout) :: watch
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Time, coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      integer :: i, j
      do i = 1, size(watch%bodies)
         if (.not. allocated(watch%bodies(i)%load)) cycle
         associate (body => watch%bodies(i), model => system%model%bodies(i), first => system%layout%q(i) + 3)
            do j = 1, model%reduced%bending
               body%deflection = max(body%deflection, abs(q(first + j))*maxval(abs(model%field%w(:, j))))
            end do
            call look(body, system, i, work%bodies(i)%load, t)
         end associate
      end do
   end subroutine watch_axial

   !> Acceleration of the stretch from three looks, and what it leaves out, eq. (148).
   pure subroutine look(body, system, index, load, t)
      type(axial_history_type), intent(inout) :: body
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      real(wp), intent(in) :: load(:), t
      !> Least time between looks, in units of the frequency: what is faster, and not round-off, needs no second look
      real(wp), parameter :: apart = 0.02_wp
      real(wp) :: size_now
      if (body%looks > 0) then
         if ((t - body%t(3))*body%frequency < apart) return
      end if
      body%load(:, :2) = body%load(:, 2:)
      body%t(:2) = body%t(2:)
      body%load(:, 3) = load
      body%t(3) = t
      body%looks = min(3, body%looks + 1)
      call add_size(system, index, load, size_now)
      body%stretched = max(body%stretched, size_now)
      if (body%looks < 3 .or. .not. body%frequency > 0.0_wp) return
      associate (x => body%load, at => body%t)
         body%lost = 2*((x(:, 3) - x(:, 2))/(at(3) - at(2)) - (x(:, 2) - x(:, 1))/(at(2) - at(1)))/(at(3) - at(1))/body%frequency**2
      end associate
      call keep_lost(body, system, index)
   end subroutine look

   !> Keeps the largest of what is left out, `lost`.
   pure subroutine keep_lost(body, system, index)
      type(axial_history_type), intent(inout) :: body
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      real(wp) :: size_now, part
      call add_size(system, index, body%lost, size_now)
      call add_tension(system, index, body%lost, part)
      body%wave = max(body%wave, size_now)
      body%tension = max(body%tension, part)
   end subroutine keep_lost

   !> Behind a break: loads that have jumped let the body ring by as much, which is left out.
   pure subroutine pass_axial_break(watch, system, work, t)
      type(axial_watch_type), intent(inout) :: watch
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: t
      real(wp) :: part
      integer :: i
      do i = 1, size(watch%bodies)
         if (.not. allocated(watch%bodies(i)%load)) cycle
         associate (body => watch%bodies(i))
            part = body%tension
            body%lost = work%bodies(i)%load - body%load(:, 3)
            if (body%looks > 0) call keep_lost(body, system, i)
            ! Bending follows the mean of tension that rings
            body%tension = part
            body%looks = 0
            call look(body, system, i, work%bodies(i)%load, t)
         end associate
      end do
   end subroutine pass_axial_break

   !> What a run has found of a body.
   pure subroutine axial_findings(watch, system, body, target, verdict)
      type(axial_watch_type), intent(in) :: watch
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: target
      type(axial_verdict_type), intent(out) :: verdict
      verdict%words = ''
      associate (found => watch%bodies(body))
         if (.not. allocated(found%load)) return
         if (.not. found%frequency > 0.0_wp) return
         verdict%frequency = found%frequency
         verdict%error = grown(system, body, found%tension + 2*found%stretched/system%model%bodies(body)%size) &
            & + start_error(system, body, found%frequency, found%starting/max(found%stretched, tiny(1.0_wp)))
         if (found%wave + found%starting > 0.0_wp) verdict%share = (found%wave + found%starting) &
            & /(found%wave + found%starting + found%deflection)
      end associate
      verdict%admissible = verdict%error <= target .and. verdict%share <= axial_share
      if (verdict%share > axial_share) then
         verdict%words = 'its stretching, at '//as_text(verdict%frequency, 3)//' rad/'//system%model%units%time// &
            & ', did not follow its loads: axial waves make '//as_text(100*verdict%share, 2)//' % of its deformation'
      else
         verdict%words = 'stretched as at rest, without its axial vibrations from '//as_text(verdict%frequency, 3)//' rad/'// &
            & system%model%units%time//' on: an error of about '//as_text(verdict%error, 2)//' of its deflections'
      end if
   end subroutine axial_findings

   !> Saves or restores its memory.
   subroutine exchange_axial_watch(self, snapshot)
      class(axial_watch_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      if (.not. allocated(self%bodies)) return
      do i = 1, size(self%bodies)
         call snapshot%exchange('frequency', self%bodies(i)%frequency)
         call snapshot%exchange('starting', self%bodies(i)%starting)
         call snapshot%keep('load', self%bodies(i)%load)
         call snapshot%keep('lost', self%bodies(i)%lost)
         call snapshot%exchange('t', self%bodies(i)%t)
         call snapshot%exchange('looks', self%bodies(i)%looks)
         call snapshot%exchange('tension', self%bodies(i)%tension)
         call snapshot%exchange('wave', self%bodies(i)%wave)
         call snapshot%exchange('stretched', self%bodies(i)%stretched)
         call snapshot%exchange('deflection', self%bodies(i)%deflection)
      end do
   end subroutine exchange_axial_watch

end module limber_analysis_axial
