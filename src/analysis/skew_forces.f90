!> Forces across the velocity in a modal analysis without damping. Such forces, magnetic or gyroscopic ones, do no work and change
!> frequencies, but have the form of damping, which the analysis leaves out. Floor: analysis. Source: doc/theory, eq. (6.8).
module limber_analysis_skew_forces
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_finite, only: unit_matrix
   use limber_base_text, only: as_text, newline
   use limber_scene_scene, only: scene_type
   use limber_analysis_small_motions, only: lowest_vibrations, undamped_terms
   use limber_model_model, only: analysis_step_type
   use limber_multibody_dense_eigenmodes, only: quadratic_modes
   use limber_multibody_equilibrium, only: equilibrium_type
   use limber_multibody_motion_laws, only: describe_law
   use limber_multibody_small_vibrations, only: vibrations_type, gyroscopic, no_damping
   use limber_multibody_sparse_eigenmodes, only: is_large
   use limber_multibody_tangent, only: tangent_type
   implicit none
   private
   public :: skew_warning

   !> Relative error of a frequency that is not told; part of the largest below which one is that of a free motion
   real(wp), parameter :: little = 2.0e-3_wp, nothing = 1.0e-5_wp

contains

   !> A warning of frequencies that forces across the velocity change: of that which changes most; empty if there is none.
   function skew_warning(scene, step, balance, vibrations, beside) result(text)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Linearised at the state
      type(equilibrium_type), intent(inout) :: balance
      !> Those that are listed, and some more, without all velocity terms
      type(vibrations_type), intent(in) :: vibrations
      !> How many more are looked for
      integer, intent(in) :: beside
      character(:), allocatable :: text
      complex(wp), allocatable :: own(:), true(:)
      logical, allocatable :: skew(:)
      real(wp) :: error, largest
      integer :: j, worst, others, listed
      logical :: done
      text = ''
      if (step%damped .or. undamped_terms(balance) /= no_damping .or. size(vibrations%frequency) == 0) return
      allocate (skew, source=skew_loads(balance%tangent))
      if (.not. any(skew)) return
      call find_true(scene, step, balance, vibrations, beside, true, done)
      if (.not. done) return
      own = cmplx(vibrations%growth, vibrations%frequency, wp)
      largest = max(maxval(abs(own)), maxval([0.0_wp, abs(true)]))
      listed = max(moving(own(:min(step%modes, size(own)))), moving(true(:min(step%modes, size(true)))))
      own = pack(own, abs(own) > nothing*largest)
      true = pack(true, abs(true) > nothing*largest .and. (aimag(true) > 0.0_wp .or. real(true, wp) > 0.0_wp))
      ! What stands behind the end of a list that is cut off is not known
      if (size(vibrations%frequency) >= step%modes) listed = min(listed, size(own), size(true))
      own = [own, [(cmplx(0.0_wp, 0.0_wp, wp), j=size(own) + 1, listed)]]
      true = [true, [(cmplx(0.0_wp, 0.0_wp, wp), j=size(true) + 1, listed)]]
      worst = 0
      others = -1
      largest = little
      do j = 1, listed
         error = abs(own(j) - true(j))/max(abs(own(j)), abs(true(j)), tiny(1.0_wp))
         if (error > little) others = others + 1
         if (error <= largest) cycle
         largest = error
         worst = j
      end do
      if (worst == 0) return
      text = "warning: *MODES '"//step%name//"' leaves out a part of "// &
         & describe_law(scene%system, strongest(scene, balance%tangent, vibrations, skew))// &
         & ' that acts across the velocity, which is no damping: '//vibration(own(worst))//' in place of '//vibration(true(worst))
      if (others > 0) text = text//' (and '//as_text(others)//' more)'
      text = text//'; use DAMPED=YES'//newline

   contains

      !> How many are no free motions.
      pure integer function moving(values)
         complex(wp), intent(in) :: values(:)
         moving = count(abs(values) > nothing*largest .and. (aimag(values) > 0.0_wp .or. real(values, wp) > 0.0_wp))
      end function moving

      !> A frequency in words.
      function vibration(value) result(words)
         complex(wp), intent(in) :: value
         character(:), allocatable :: words
         words = as_text(aimag(value), 4)//' rad/'//scene%system%model%units%time
         if (.not. aimag(value) > 0.0_wp) words = 'no vibration'
      end function vibration

   end function skew_warning

   !> Loads whose damping is not symmetric.
   pure function skew_loads(tangent) result(skew)
      type(tangent_type), intent(in) :: tangent
      logical :: skew(size(tangent%loads))
      !> Difference beside the largest entry that is round-off
      real(wp), parameter :: none = 1.0e-9_wp
      integer :: i
      do i = 1, size(skew)
         associate (block => tangent%loads(i)%damping)
            skew(i) = .false.
            if (size(block) > 0) skew(i) = maxval(abs(block - transpose(block))) > none*maxval(abs(block))
         end associate
      end do
   end function skew_loads

   !> The roots with the part of D that is skew, eq. (6.8): of a large scene on the modes that are listed.
   subroutine find_true(scene, step, balance, vibrations, beside, roots, done)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(equilibrium_type), intent(inout) :: balance
      type(vibrations_type), intent(in) :: vibrations
      integer, intent(in) :: beside
      !> s (modes)
      complex(wp), allocatable, intent(out) :: roots(:)
      logical, intent(out) :: done
      type(vibrations_type) :: other
      type(error_type), allocatable :: error
      complex(wp), allocatable :: vector(:, :)
      real(wp), allocatable :: stiffness(:, :), across(:, :)
      integer :: j, n
      n = size(vibrations%frequency)
      if (is_large(scene%system)) then
         allocate (stiffness, source=unit_matrix(n))
         allocate (across(n, n), source=0.0_wp)
         do j = 1, n
            stiffness(j, j) = vibrations%frequency(j)**2 - vibrations%growth(j)**2
         end do
         do j = 1, size(balance%tangent%loads)
            call add_skew(balance%tangent, j, real(vibrations%shape, wp), across)
         end do
         call quadratic_modes(unit_matrix(n), across, stiffness, n, roots, vector)
         done = allocated(roots)
      else
         call lowest_vibrations(scene, balance, gyroscopic, step%modes, beside, other, error)
         done = .not. allocated(error)
         if (done) roots = cmplx(other%growth, other%frequency, wp)
      end if
   end subroutine find_true

   !> Adds the skew part of the damping of a load on shapes.
   pure subroutine add_skew(tangent, load, shapes, across)
      type(tangent_type), intent(in) :: tangent
      integer, intent(in) :: load
      !> (nw, modes)
      real(wp), intent(in) :: shapes(:, :)
      !> (modes, modes)
      real(wp), intent(inout) :: across(:, :)
      real(wp) :: local(size(tangent%loads(load)%unknowns), size(shapes, 2)), forces(size(local, 1), size(local, 2)), &
         & part(size(shapes, 2), size(shapes, 2))
      local = shapes(tangent%loads(load)%unknowns, :)
      forces = matmul(tangent%loads(load)%damping, local)
      part = matmul(transpose(local), forces)
      across = across + 0.5_wp*(part - transpose(part))
   end subroutine add_skew

   !> Index of the first part of the load that couples the modes most; the first that is skew if none does.
   integer function strongest(scene, tangent, vibrations, skew) result(load)
      type(scene_type), intent(in) :: scene
      type(tangent_type), intent(in) :: tangent
      type(vibrations_type), intent(in) :: vibrations
      logical, intent(in) :: skew(:)
      real(wp), allocatable :: across(:, :)
      real(wp) :: most
      integer :: i, k, n
      n = size(vibrations%frequency)
      load = findloc(skew, .true., dim=1)
      most = 0.0_wp
      allocate (across(n, n))
      do i = 1, size(scene%system%model%loads)
         associate (named => scene%system%model%loads(i))
            across = 0.0_wp
            do k = named%first, named%last
               call add_skew(tangent, k, real(vibrations%shape, wp), across)
            end do
            if (maxval(abs(across)) <= most) cycle
            most = maxval(abs(across))
            load = named%first
         end associate
      end do
   end function strongest

end module limber_analysis_skew_forces
