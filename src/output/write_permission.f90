!> Places at which limber may write. Never in place of a file of the deck, a folder, a pipe or a device, whatever `--force` says,
!> and beside its results only in place of what it has made itself. Floor: output.
module limber_output_write_permission
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: kind_of_path, same_file, path_free, path_file, path_folder
   use limber_output_checkpoint, only: checkpoint_name, checkpoint_format
   use limber_output_own_files, only: check_own
   use limber_output_working_file, only: working_name
   implicit none
   private
   public :: check_place, check_results_place

contains

   !> Refuses a place that holds what may not be replaced, not even with `--force`.
   subroutine check_place(path, sources, error)
      !> Name of a file that is to be written
      character(*), intent(in) :: path
      !> Files of the deck, those that it includes among them
      character(*), intent(in) :: sources(:)
      !> Allocated if it is one of these, or no file
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      select case (kind_of_path(path))
      case (path_free); return
      case (path_folder); call raise(error, 'cannot create '//path//': Is a directory', status_deck)
      case (path_file)
         do i = 1, size(sources)
            if (allocated(error)) exit
            if (same_file(path, trim(sources(i)))) call raise(error, 'cannot write '//path//': '//trim(sources(i))// &
               & ' is a file of the deck, which is never replaced; give -o for another name', status_deck)
         end do
      case default
         call raise(error, 'cannot write '//path//': it is a pipe or a device, not a file; give -o for another name', status_deck)
      end select
   end subroutine check_place

   !> The same for a results file and all that a run makes beside it for a while.
   subroutine check_results_place(results, sources, reads, error)
      !> Name of the results
      character(*), intent(in) :: results, sources(:)
      !> Whether the checkpoint is going to be read, and judged then
      logical, intent(in) :: reads
      !> Allocated if one of them would replace what is not limber's
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: checkpoint
      checkpoint = checkpoint_name(results)
      call check_place(results, sources, error)
      call check_beside(working_name(results), '')
      call check_beside(results//'.new', '')
      if (.not. reads) call check_beside(checkpoint, checkpoint_format)
      call check_beside(checkpoint//'.new', '')

   contains

      subroutine check_beside(path, format)
         character(*), intent(in) :: path, format
         if (.not. allocated(error)) call check_place(path, sources, error)
         if (.not. allocated(error)) call check_own(path, format, error)
      end subroutine check_beside

   end subroutine check_results_place

end module limber_output_write_permission
