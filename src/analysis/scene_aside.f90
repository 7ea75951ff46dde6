!> Second scene with more coordinates at the same place. What it tells otherwise, the coordinates of the scene leave out. Floor:
!> analysis. Source: doc/theory, eq. (7.49).
module limber_analysis_scene_aside
   use limber_base_kinds, only: wp
   use limber_beam_static_functions, only: may_be_lost
   use limber_base_error, only: error_type
   use limber_analysis_richer_scene, only: richer_deck, can_enrich, project_coordinates, nothing_more
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_multibody_equilibrium, only: equilibrium_type, new_equilibrium, find_equilibrium
   use limber_multibody_switching, only: set_switches
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: aside_type, build_aside, place_aside, additional_modes, add_missed

   !> Coordinates of a scene up to which each body gets as many modes as are wanted; a few in any case
   integer, parameter :: many = 600, few = 3

   !> The scene with more coordinates. `class`: the compiler then frees and copies a scene by one procedure, instead of writing that
   !> out wherever an object with a scene is made
   type :: aside_type
      class(scene_type), allocatable :: scene
      type(equilibrium_type) :: balance
   end type aside_type

contains

   !> Number of modes that each body gets beside those that it has.
   pure integer function additional_modes(system, level, wanted) result(extra)
      type(system_type), intent(in) :: system
      !> What each body gets (bodies), some of them something; number that is wanted
      integer, intent(in) :: level(:), wanted
      extra = max(few, min(wanted, (many - system%layout%nw)/count(level /= nothing_more)))
   end function additional_modes

   !> Builds it.
   subroutine build_aside(scene, level, extra, with_outputs, aside, done)
      type(scene_type), intent(in) :: scene
      !> What each body gets (bodies), and the number of additional modes
      integer, intent(in) :: level(:), extra
      !> Whether it has the channels
      logical, intent(in) :: with_outputs
      type(aside_type), intent(inout) :: aside
      !> Whether it can be built
      logical, intent(out) :: done
      logical :: renewed
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      if (.not. allocated(aside%scene)) allocate (scene_type :: aside%scene)
      aside%scene%deck = richer_deck(scene, level, extra, with_outputs)
      call build_scene(aside%scene, diagnostics, error)
      done = .not. allocated(error)
      if (done .and. size(scene%system%on) > 0) call set_switches(aside%scene%system, aside%scene%work, scene%system%on, renewed)
      if (done) done = aside%scene%system%nc == scene%system%nc
      ! More modes of a frame may leave no mass for its responses: then there is less to it
      if (done) done = all(aside%scene%system%model%bodies%lost <= max(scene%system%model%bodies%lost, may_be_lost))
      if (done) call new_equilibrium(aside%scene%system, aside%balance)
   end subroutine build_aside

   !> Places it where the scene is, under its loads; if that is in equilibrium, in its own equilibrium near by.
   subroutine place_aside(scene, t, q, lambda, balanced, rotation, centre, aside, done)
      type(scene_type), intent(in) :: scene
      !> Time, coordinates (nq), multipliers of the equilibrium if it is one (nc), steady rotation and its centre
      real(wp), intent(in) :: t, q(:), lambda(:), rotation, centre(2)
      logical, intent(in) :: balanced
      type(aside_type), intent(inout) :: aside
      !> Whether its equilibrium was found, if it is one
      logical, intent(out) :: done
      integer :: i, k
      associate (new => aside%scene)
         call project_coordinates(scene%system, new%system, q, new%q)
         new%v = 0.0_wp
         new%system%model%gravity = scene%system%model%gravity
         new%system%model%dynamics = scene%system%model%dynamics
         ! Loads along a body may have more parts here: all that grow have one share
         do k = 1, size(scene%system%loads)
            associate (load => scene%system%loads(k)%item)
               if (.not. load%grows) cycle
               do i = 1, size(new%system%loads)
                  if (.not. new%system%loads(i)%item%grows) cycle
                  new%system%loads(i)%item%is_scaled = load%is_scaled
                  new%system%loads(i)%item%share = load%share
               end do
               exit
            end associate
         end do
         if (size(new%work%kinematics%angles) == size(scene%work%kinematics%angles)) &
            & new%work%kinematics%angles = scene%work%kinematics%angles
         new%last%balanced = balanced
         new%last%rotation = rotation
         new%last%centre = centre
         done = .true.
         if (.not. balanced) return
         new%last%lambda = lambda
         aside%balance%rotation = rotation
         aside%balance%centre = centre
         call find_equilibrium(new%system, new%work, aside%balance, t, new%q, new%last%lambda, .true., done)
      end associate
   end subroutine place_aside

   !> Adds for each body the strain energy of a motion in what the scene lacks of it.
   subroutine add_missed(system, richer, motion, energy)
      type(system_type), intent(in) :: system, richer
      !> In the layout of the rates of the richer one (nw)
      real(wp), intent(in) :: motion(:)
      !> (bodies)
      real(wp), intent(inout) :: energy(:)
      real(wp) :: kept(richer%layout%nw), fewer(system%layout%nw)
      integer :: i, first, last
      call project_coordinates(richer, system, motion, fewer, rates=.true.)
      call project_coordinates(system, richer, fewer, kept, rates=.true.)
      do i = 1, size(energy)
         if (.not. (can_enrich(system%model%bodies(i)) .or. system%model%bodies(i)%reduced%is_exact)) cycle
         first = richer%layout%w(i) + 3
         last = first + richer%layout%n(i) - 1
         energy(i) = energy(i) + sum(richer%model%bodies(i)%reduced%omega2*(motion(first:last) - kept(first:last))**2)
      end do
   end subroutine add_missed

end module limber_analysis_scene_aside
